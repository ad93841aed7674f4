"""A, H, B, G from lists of rows, sparse mappings, one expression, or right-hand sides.

dynamics:      x' = A x + B u + G w     each right-hand side a linear form
measurements:  y  = H x
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from collections.abc import Sequence as SequenceOf
from dataclasses import dataclass

from obscli.core.place import Place
from obscli.model.draft import Entries, Sparse
from obscli.model.evaluate import evaluate
from obscli.model.expression import Expression, is_zero
from obscli.model.form import ZERO_FORM, Form, is_zero_form
from obscli.model.formula import Formula
from obscli.model.scope import Scope
from obscli.model.system import Matrix
from obscli.model.tensor import Tensor, named
from obscli.model.tree import Node, Sequence
from obscli.model.trouble import Problems, nearest, shown


@dataclass(frozen=True, slots=True, eq=False)
class Row:
    """One right-hand side, scalar: its name, its form, where it stands."""

    name: str
    form: Form
    place: Place


def cell_place(node: Node, *position: int) -> Place:
    """Return the place of an entry in nested lists, or of the nearest list around it."""
    for k in position:
        if not isinstance(node, Sequence) or k >= len(node.items):
            break
        node = node.items[k]
    return node.place


def dense(
    formula: Formula, rows: int | None, columns: int, scope: Scope, problems: Problems
) -> Matrix | None:
    """Return the matrix of an expression or of a list of rows; ``rows`` None: any number."""
    value = evaluate(formula, scope, problems)
    if value is None:
        return None
    shape = (1, 1) if value.is_scalar else value.shape
    if len(shape) != 2 or shape[1] != columns or rows not in {None, shape[0]}:
        wanted = f"an m×{columns} matrix" if rows is None else f"a {rows}×{columns} matrix"
        hint = "one row is written [[…]], with two pairs of brackets" if len(shape) == 1 else ""
        problems.add(formula.problem(f"{wanted} is expected here, not {named(value.shape)}", hint))
        return None
    cells = ((i, j, value.entries[i * columns + j].constant) for i in range(shape[0]) for j in range(columns))
    entries = {(i, j): node for i, j, node in cells if not is_zero(node)}
    return Matrix(shape[0], columns, entries, {key: cell_place(formula.node, *key) for key in entries})


def sparse(
    matrix: Sparse, rows: SequenceOf[str], columns: Mapping[str, int], scope: Scope, problems: Problems
) -> Matrix:
    """Return the matrix given by names; ``columns`` maps every accepted spelling to its place."""
    entries: dict[tuple[int, int], Expression] = {}
    places: dict[tuple[int, int], Place] = {}
    index = {name: i for i, name in enumerate(rows)}
    for name, (key, row) in matrix.rows.items():
        if name not in index:
            message = f"'{shown(name)}' names no row of this matrix{nearest(name, index)}"
            problems.add(key.problem(matrix.path, message))
            continue
        found = _row(row, matrix.path, columns, scope, problems)
        for j, node, place in found:
            if not is_zero(node):
                entries[index[name], j] = node
                places[index[name], j] = place
    return Matrix(len(rows), len(set(columns.values())), entries, places)


def _row(
    row: Entries | Formula, path: str, columns: Mapping[str, int], scope: Scope, problems: Problems
) -> Iterator[tuple[int, Expression, Place]]:
    if isinstance(row, Formula):
        value = evaluate(row, scope, problems)
        size = len(set(columns.values()))
        if value is not None and value.shape not in {(size,), (1, size)}:
            message = f"a row of {size} is expected here, not {named(value.shape)}"
            problems.add(row.problem(message, "or a mapping of column names to entries"))
        elif value is not None:
            yield from ((j, form.constant, cell_place(row.node, j)) for j, form in enumerate(value.entries))
        return
    for name, entry in row.items():
        if name not in columns:
            message = f"'{shown(name)}' names no column of this matrix{nearest(name, columns)}"
            problems.add(entry.key.problem(path, message))
            continue
        if entry.formula is None:
            problems.add(entry.key.problem(path, "an expression is missing here"))
            continue
        value = evaluate(entry.formula, scope, problems)
        if value is not None and not value.is_scalar:
            problems.add(entry.formula.problem(f"an entry is a scalar, not {named(value.shape)}"))
        elif value is not None:
            yield columns[name], value.entries[0].constant, entry.formula.place


def linear_rows(
    formula: Formula, names: SequenceOf[str | None], value: Tensor, problems: Problems, *, local: bool
) -> Iterator[Row]:
    """Yield the rows of a right-hand side; a cell without name must be 0.

    Parameters
    ----------
    local : whether the right-hand side is linearised; a constant term is refused otherwise
    """
    for k, (name, form) in enumerate(zip(names, value.entries, strict=True)):
        if not local and not is_zero(form.constant):
            hint = (
                "a known input or constant does not change what is observable: leave it out, "
                "or name it under `inputs`"
            )
            problems.add(formula.problem("a term without a state stands on this right-hand side", hint))
            return
        if name is None and not is_zero_form(form):
            problems.add(formula.problem("an entry that the structure of the matrix makes zero is not zero"))
            return
        if name is not None:
            yield Row(name, form, cell_place(formula.node, k))


def assemble(rows: SequenceOf[Row | None], columns: SequenceOf[str]) -> Matrix:
    """Return the matrix of the coefficients of the columns' names in the rows."""
    index = {name: j for j, name in enumerate(columns)}
    entries: dict[tuple[int, int], Expression] = {}
    places: dict[tuple[int, int], Place] = {}
    for i, row in enumerate(rows):
        for name, node in (row.form if row else ZERO_FORM).linear.items():
            if row is not None and name in index and not is_zero(node):
                entries[i, index[name]] = node
                places[i, index[name]] = row.place
    return Matrix(len(rows), len(columns), entries, places)
