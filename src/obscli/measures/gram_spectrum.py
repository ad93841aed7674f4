"""Singular values and vectors of a matrix in an orthonormal basis of its rows, to many digits.

    S = C U,   Cᵀ C w_i = σ_i² w_i,   v_i = Uᵀ w_i

Squaring C costs half of the digits, and of those there are to be enough: ``survives_squaring``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from flint import acb_mat, arb, arb_mat

from obscli.measures.in_range import as_double


#: Singular values that agree so well, relatively, are one: data in double precision tell no more.
_ALIKE: Final = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class GramSpectrum:
    """Eigenvalues σ_i² of Cᵀ C, the largest first.

    Parameters
    ----------
    squares : σ_i², r numbers
    vectors : W, columns w_i (not orthogonal among equal ones), shape (r, r)
    inverse : W⁻¹
    U : orthonormal rows, shape (r, n)
    """

    squares: tuple[arb, ...]
    vectors: arb_mat
    inverse: arb_mat
    U: arb_mat

    @property
    def values(self) -> tuple[float | None, ...]:
        """σ_i, None where one is beyond double precision."""
        return tuple(as_double(one.sqrt()) for one in self.squares)

    @property
    def condition(self) -> arb:
        """σ_1/σ_r, ∞ where r is 0."""
        return (self.squares[0] / self.squares[-1]).sqrt() if self.squares else arb.pos_inf()

    @property
    def clusters(self) -> tuple[tuple[int, ...], ...]:
        """The indices of equal singular values, together."""
        found: list[list[int]] = []
        for k, square in enumerate(self.squares):
            if found and self.squares[found[-1][-1]] - square <= 2 * _ALIKE * square:
                found[-1].append(k)
            else:
                found.append([k])
        return tuple(tuple(one) for one in found)

    def function(self, f: tuple[arb, ...]) -> arb_mat:
        """Return W diag(f) W⁻¹, shape (r, r): f = σ gives (Cᵀ C)^½."""
        r = len(self.squares)
        diagonal = arb_mat(r, r, [f[i] if i == j else 0 for i in range(r) for j in range(r)])
        return self.vectors * diagonal * self.inverse

    def right_vector(self, i: int) -> tuple[arb, ...]:
        """Return v_i of unit length, n numbers."""
        r = len(self.squares)
        w = arb_mat(1, r, [self.vectors[k, i] for k in range(r)])
        v = (w * self.U).entries()
        size = sum((entry * entry for entry in v), arb(0)).sqrt()
        return tuple(entry / size for entry in v)


def gram_spectrum(C: arb_mat, U: arb_mat) -> GramSpectrum:
    """Return the singular values and vectors of C U; use inside ``precision``.

    Parameters
    ----------
    C : of full column rank, shape (N, r)
    U : orthonormal rows, shape (r, n)
    """
    r = C.ncols()
    if not r:
        return GramSpectrum((), arb_mat(0, 0), arb_mat(0, 0), U)
    gram = (C.transpose() * C).mid()
    found, vectors = acb_mat(gram).eig(right=True, algorithm="approx")
    squares = [one.real.mid() for one in found]
    order = sorted(range(r), key=lambda k: squares[k], reverse=True)
    W = arb_mat(r, r, [vectors[i, k].real.mid() for i in range(r) for k in order])
    return GramSpectrum(tuple(squares[k] for k in order), W, W.inv(), U)
