"""Gram–Schmidt orthogonalisation of the rows of an observability matrix, in balls.

    M = C U,   U Uᵀ = I,   c_kk = r_k = |a_k − a_k*| > 0

A row whose residual is zero is skipped. The rows of C that the residuals come from make a lower triangle T
with the r_k on its diagonal; its inverse bounds that of C:

    σ_r(C) ≥ σ_r(T) ≥ 1/|T⁻¹|,   |C| |T⁻¹| ≥ cond C        (Frobenius norms)

Balls cannot prove a residual zero; but the rank is known exactly,
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

#: Bits that are to be left when the condition has taken its own: those of double precision, and as many more.
_SPARE: Final = 128

#: Bits that elimination in balls takes for every row.
_SPARE_A_ROW: Final = 3


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

    @property
    def survives_squaring(self) -> bool:
        """Whether Cᵀ C, and what is found from it in the precision in force, is known to double precision.

        Squaring takes twice the digits of the condition: of those of the arithmetic, and of those of C.
        """
        if not self.rank:
            return True
        condition = _size(self.C) * self._inverse_size()
        if not condition.is_finite():
            return False
        needed = 2 * condition.log().mid() / arb(2).log() + _SPARE + _SPARE_A_ROW * self.rank
        wrong = _size(arb_mat(self.C.nrows(), self.rank, [one.rad() for one in self.C.entries()]))
        return bool(needed < ctx.prec and wrong * arb(2) ** needed < _size(self.C))

    def _inverse_size(self) -> arb:
        """Return |T⁻¹|, not finite where T is not told from a singular matrix."""
        rows = self.C.tolist()
        triangle = arb_mat(
            [[rows[k][j] if j <= i else arb(0) for j in range(self.rank)] for i, k in enumerate(self.origins)]
        )
        return _size(triangle.inv(nonstop=True))


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


def _size(matrix: arb_mat) -> arb:
    """Return a bound of the Frobenius norm."""
    return sum((one.abs_upper() ** 2 for one in matrix.entries()), arb(0)).sqrt()


def _stacked(rows: Sequence[arb_mat]) -> arb_mat:
    return arb_mat([list(row.entries()) for row in rows])


def _norm(row: arb_mat) -> arb:
    return sum((entry * entry for entry in row.entries()), arb(0)).nonnegative_part().sqrt()
