"""The matrix between two bases of the same space of observable covectors.

With the proved basis S in reduced echelon form, pivots p_k, a basis C of the same rows space is C = T S with

    T_jk = C_j[p_k] / S_k[p_k]
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeAlias

from obscli.exact.restore import Restorer
from obscli.model.expression import Expression


if TYPE_CHECKING:
    from obscli.exact.exact_system import ExactSystem, Row

#: Rows of expressions, zeros absent: {k: T_jk}.
Transformation: TypeAlias = tuple[dict[int, Expression], ...]


def transformation(
    exact: ExactSystem, proved: Sequence[Row], claimed: Sequence[Row]
) -> Transformation | None:
    """Return T with claimed = T · proved, None where the proved rows are not in reduced echelon form.

    Parameters
    ----------
    proved : the proved basis, rows by column
    claimed : rows of the same span
    """
    pivots = [min(row) for row in proved]
    if any(pivot in row for k, pivot in enumerate(pivots) for j, row in enumerate(proved) if j != k):
        return None
    restorer = Restorer(exact.interpreter)
    return tuple(
        {k: restorer.element(row[pivot] / proved[k][pivot]) for k, pivot in enumerate(pivots) if pivot in row}
        for row in claimed
    )


def is_rearranged(matrix: Transformation) -> bool:
    """Whether every claimed row is a multiple of one proved row."""
    return all(len(row) == 1 for row in matrix)
