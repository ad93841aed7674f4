"""Gram–Schmidt orthogonalisation of the rows of an observability matrix, in balls.

    M = C U,   U Uᵀ = I,   c_kk = r_k = |a_k − a_k*| > 0

A row whose residual is zero is skipped. Balls cannot prove a residual zero; but the rank is known exactly,
and where so many residuals are proved to be nonzero the others must vanish.

References
----------
I. A. Bagmut (2009), the recurrence before (3).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from flint import arb, arb_mat, ctx


#: A residual is taken as zero if its ball holds zero and is smaller than this power of the precision.
_TINY: Final = 0.5


class ImpreciseError(ArithmeticError):
    """Residuals cannot be told from zero at the precision in force."""


@dataclass(frozen=True, slots=True, eq=False)
class OrthogonalRows:
    """M = C U.

    Parameters
    ----------
    U : orthonormal rows, shape (r, n)
    C : shape (N, r)
    residuals : r_k, in the order of the rows of U
    origins : the row of M that each comes from
    """

    U: arb_mat
    C: arb_mat
    residuals: tuple[arb, ...]
    origins: tuple[int, ...]

    @property
    def rank(self) -> int:
        """How many rows are independent."""
        return len(self.residuals)


def orthogonalised(rows: Sequence[Sequence[arb]], rank: int) -> OrthogonalRows:
    """Return the rows of a matrix of known rank in an orthonormal basis; use inside ``precision``.

    Parameters
    ----------
    rows : of M, shape (N, n)
    rank : no more than so many residuals differ from zero

    Returns
    -------
    OrthogonalRows
        of a rank below the one given where the others are zero as far as the balls tell

    Raises
    ------
    ImpreciseError
        where a residual is neither proved nonzero nor tiny
    """
    n = len(rows[0]) if rows else 0
    basis: list[arb_mat] = []
    residuals, origins = [], []
    for k, row in enumerate(rows):
        if len(basis) == rank:
            break
        rest = arb_mat(1, n, list(row))
        size = _norm(rest)
        for _ in range(2 if basis else 0):  # twice is enough
            U = _stacked(basis)
            rest = rest - (rest * U.transpose()) * U
        residual = _norm(rest)
        if residual > 0:
            basis.append(rest * (1 / residual))
            residuals.append(residual)
            origins.append(k)
        elif not residual.abs_upper() <= size.abs_upper() * arb(2) ** int(-_TINY * ctx.prec):
            raise ImpreciseError
    U = _stacked(basis) if basis else arb_mat(0, n)
    M = arb_mat(len(rows), n, [entry for row in rows for entry in row])
    return OrthogonalRows(U, M * U.transpose(), tuple(residuals), tuple(origins))


def _stacked(rows: Sequence[arb_mat]) -> arb_mat:
    return arb_mat([list(row.entries()) for row in rows])


def _norm(row: arb_mat) -> arb:
    return sum((entry * entry for entry in row.entries()), arb(0)).nonnegative_part().sqrt()
