"""block([[A, B], [C, D]]): a matrix of matrices; a scalar 0 is a block of zeros of the size that fits."""

from __future__ import annotations

from obscli.model.form import ZERO_FORM, Form, Impossible, is_zero_form
from obscli.model.tensor import Tensor, matrix, named


def block(rows: tuple[tuple[Tensor, ...], ...]) -> Tensor:
    """Return the matrix the blocks make; vectors are columns.

    Raises
    ------
    Impossible
        where the blocks of a row differ in height, those of a column in width
    """
    if not rows or not rows[0] or any(len(row) != len(rows[0]) for row in rows):
        raise Impossible("every row of block([[...]]) must hold the same number of blocks")
    columns = tuple(zip(*rows, strict=True))
    heights = [_agreed(row, 0, f"row {k}") for k, row in enumerate(rows, start=1)]
    widths = [_agreed(column, 1, f"column {k}") for k, column in enumerate(columns, start=1)]
    row_of = [(k, i) for k, height in enumerate(heights) for i in range(height)]
    column_of = [(k, j) for k, width in enumerate(widths) for j in range(width)]

    def entry(i: int, j: int) -> Form:
        (row, i), (column, j) = row_of[i], column_of[j]
        part = rows[row][column]
        return ZERO_FORM if _is_zero(part) else part.entries[i * widths[column] + j]

    return matrix(len(row_of), len(column_of), entry)


def _is_zero(part: Tensor) -> bool:
    return part.shape == () and is_zero_form(part.entries[0])


def _size(part: Tensor, axis: int) -> int:
    return (*part.shape, 1, 1)[axis]


def _agreed(parts: tuple[Tensor, ...], axis: int, where: str) -> int:
    """Return the common height (axis 0) or width (axis 1) of the blocks."""
    sizes = {_size(part, axis) for part in parts if not _is_zero(part)} or {1}
    if len(sizes) > 1:
        found = " and ".join(sorted({named(part.shape) for part in parts}))
        raise Impossible(f"the blocks in {where} do not fit together: {found}")
    return sizes.pop()
