"""y = H x from ``measurements`` or from the matrix H, and the names of the outputs."""

from __future__ import annotations

from collections.abc import Sequence

from obscli.model.declaration import component_names
from obscli.model.draft import Draft, Sparse
from obscli.model.dynamics import columns_of, names_of
from obscli.model.evaluate import evaluate
from obscli.model.matrices import Row, assemble, dense, linear_rows, sparse
from obscli.model.scope import Scope
from obscli.model.system import Matrix, Output
from obscli.model.trouble import Problems, nearest, shown


def observation(
    draft: Draft, plain: Scope, linear: Scope, problems: Problems
) -> tuple[Matrix, tuple[Output, ...]] | None:
    """Return H (m, n) and the outputs; None where they are missing or wrong."""
    matrix = draft.matrices.get("H")
    if draft.measurements is not None:
        return _measured(draft, linear, problems)
    if matrix is None:
        return None
    if isinstance(matrix, Sparse):
        names = tuple(matrix.rows)
        outputs = [Output(name, key.place, "", _unit(draft, name)) for name, (key, _) in matrix.rows.items()]
        _check_names(draft, names, problems)
        return sparse(matrix, names, columns_of(draft.states), plain, problems), tuple(outputs)
    H = dense(matrix, None, len(names_of(draft.states)), plain, problems)
    if H is None:
        return None
    names = tuple(f"y{i}" for i in range(1, H.rows + 1))
    if len(draft.outputs) == H.rows and not {"y", *names} > draft.outputs.keys() > {"y"}:
        pairs = draft.outputs.items()
        return H, tuple(Output(name, one.key.place, "", one.unit) for name, one in pairs)
    _check_names(draft, (*names, "y"), problems)
    return H, tuple(Output(name, matrix.place, "y", _unit(draft, name, "y")) for name in names)


def _unit(draft: Draft, *names: str) -> str:
    units = (draft.outputs[name].unit for name in names if name in draft.outputs)
    return next((unit for unit in units if unit), "")


def _check_names(draft: Draft, known: Sequence[str], problems: Problems) -> None:
    for name, one in draft.outputs.items():
        if name not in known:
            message = f"'{shown(name)}' is no output{nearest(name, known)}"
            problems.add(one.key.problem("outputs", message))


def _measured(draft: Draft, scope: Scope, problems: Problems) -> tuple[Matrix, tuple[Output, ...]]:
    rows: list[Row] = []
    outputs: list[Output] = []
    for name, entry in (draft.measurements or {}).items():
        value = None if entry.formula is None else evaluate(entry.formula, scope, problems)
        if value is None or entry.formula is None:
            continue
        shape = () if value.is_scalar else value.shape
        names = component_names(name, shape)
        local = draft.linearize is not None
        found = list(linear_rows(entry.formula, names, value, problems, local=local))
        rows += found
        vector = name if shape else ""
        outputs += [Output(row.name, row.place, vector, _unit(draft, row.name, name)) for row in found]
    known = [*(draft.measurements or {}), *(output.name for output in outputs)]
    _check_names(draft, known, problems)
    _check_twice(draft, outputs, problems)
    return assemble(rows, names_of(draft.states)), tuple(outputs)


def _check_twice(draft: Draft, outputs: Sequence[Output], problems: Problems) -> None:
    seen: set[str] = set()
    for output in outputs:
        if output.name in seen:
            entry = (draft.measurements or {}).get(output.vector or output.name)
            if entry is not None:
                message = f"two outputs have the name '{output.name}'"
                problems.add(entry.key.problem("measurements", message))
        seen.add(output.name)
