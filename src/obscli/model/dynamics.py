"""x' = A x + B u + G w from ``dynamics`` or from the matrices, or x(k+1) = F x + B u + G w from these."""

from __future__ import annotations

from dataclasses import dataclass

from obscli.model.declaration import Declared
from obscli.model.draft import Draft, Entry, Sparse
from obscli.model.evaluate import evaluate
from obscli.model.matrices import Row, assemble, dense, linear_rows, sparse
from obscli.model.scope import Scope
from obscli.model.system import Matrix
from obscli.model.tensor import Tensor, named
from obscli.model.trouble import Problems, nearest, shown


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """A, or F, (n, n), B (n, p), G (n, q), with the names of inputs and disturbances."""

    A: Matrix
    B: Matrix | None
    G: Matrix | None
    inputs: tuple[str, ...]
    disturbances: tuple[str, ...]


def names_of(group: tuple[Declared, ...]) -> tuple[str, ...]:
    """Return the scalar names declared."""
    return tuple(name for one in group for name in one.components)


def columns_of(group: tuple[Declared, ...]) -> dict[str, int]:
    """Return the column of every accepted spelling of a scalar name."""
    columns = {name: j for j, name in enumerate(names_of(group))}
    for one in group:
        for alias, name in one.aliases():
            columns.setdefault(alias, columns[name])
    return columns


def motion(draft: Draft, plain: Scope, linear: Scope, problems: Problems) -> Motion | None:
    """Return the dynamics; None where they are missing or wrong.

    Parameters
    ----------
    plain, linear : the scope without and with states, inputs and disturbances
    """
    n = len(names_of(draft.states))
    rows: list[Row | None] = [None] * n
    if draft.dynamics is not None:
        rows = _rows(draft, linear, problems)
        A: Matrix | None = assemble(rows, names_of(draft.states))
    else:
        A = _given(draft, "F" if draft.is_discrete else "A", n, plain, problems)
    result = []
    for key, group in (("B", draft.inputs), ("G", draft.disturbances)):
        names = names_of(group)
        matrix = assemble(rows, names) if names and draft.dynamics is not None else None
        if key in draft.matrices:
            matrix = _given(draft, key, None if not names else len(names), plain, problems)
            letter = "u" if key == "B" else "w"
            width = matrix.columns if matrix else 0
            names = names or tuple(f"{letter}{j}" for j in range(1, width + 1))
        result.append((matrix, names))
    (B, inputs), (G, disturbances) = result
    return None if A is None else Motion(A, B, G, inputs, disturbances)


def _given(draft: Draft, key: str, columns: int | None, scope: Scope, problems: Problems) -> Matrix | None:
    """Return a matrix written as such."""
    matrix = draft.matrices.get(key)
    if matrix is None:
        return None
    states = names_of(draft.states)
    if isinstance(matrix, Sparse):
        group = {"A": draft.states, "F": draft.states, "B": draft.inputs, "G": draft.disturbances}[key]
        return sparse(matrix, states, columns_of(group), scope, problems)
    if columns is None:
        value = evaluate(matrix, scope, problems)
        if value is None:
            return None
        columns = value.shape[1] if len(value.shape) == 2 else 1
    return dense(matrix, len(states), columns, scope, problems)


def _rows(draft: Draft, scope: Scope, problems: Problems) -> list[Row | None]:
    """Return the right-hand side of every scalar state, None where it is constant."""
    found: dict[str, Row] = {}
    wholes = {one.name: one for one in draft.states}
    scalars = columns_of(draft.states)
    states = names_of(draft.states)
    for name, entry in (draft.dynamics or {}).items():
        if name not in wholes and name not in scalars:
            message = f"'{shown(name)}' is no state{nearest(name, [*wholes, *scalars])}"
            problems.add(entry.key.problem("dynamics", message))
            continue
        cells = wholes[name].cells if name in wholes else (states[scalars[name]],)
        shape = wholes[name].shape if name in wholes else ()
        value = None if entry.formula is None else evaluate(entry.formula, scope, problems)
        if value is not None:
            _keep(entry, cells, shape, value, found, problems, local=draft.linearize is not None)
    return [found.get(state) for state in states]


def _keep(
    entry: Entry,
    cells: tuple[str | None, ...],
    shape: tuple[int, ...],
    value: Tensor,
    found: dict[str, Row],
    problems: Problems,
    *,
    local: bool,
) -> None:
    assert entry.formula is not None
    if value.shape != shape and not (value.is_scalar and len(cells) == 1):
        message = f"'{entry.key.text}' is {named(shape)}; its right-hand side is {named(value.shape)}"
        problems.add(entry.formula.problem(message))
        return
    before = set(found)
    for row in linear_rows(entry.formula, cells, value, problems, local=local):
        if row.name in before:
            problems.add(entry.key.problem("dynamics", f"the right-hand side of '{row.name}' is given twice"))
        found[row.name] = row
