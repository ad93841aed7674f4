"""The observability Gramian at some instants, by whatever method, with what is known of its error.

    W(t, t0) = ∫ Φᵀ(τ, t) Hᵀ H Φ(τ, t) dτ = Rᵀ R

W and any square root R of it have the same kernel and the same row space, that of the observable covectors.
Neither changes where the integrand is weighted with anything positive, or the window (t0, t) is shortened.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias

import numpy as np

from obscli.numeric.program import EPS, Array, Flags


#: The squared error where nothing is known of the Gramian.
LOST: Final = 1e300

#: Up to so many states a factorisation or a product is wrong by one unit of rounding.
_SMALL: Final = 24

#: How the Gramian is found: as a square root, by its differential equation, by its definition, from a
#: stationary system.
Method: TypeAlias = Literal["square-root", "lyapunov", "quadrature", "lift"]


@dataclass(frozen=True, slots=True, eq=False)
class Gramian:
    """M_i = R(t_i) D_i or D_i W(t_i, t0) D_i for N instants, in units D_i of the states: x = D z.

    Parameters
    ----------
    method : how it was found
    instants : t_i, shape (N,)
    starts : t0 of the window of each, or its last sample where it looks forward, shape (N,)
    matrices : M_i, shape (N, n, n)
    units : the diagonals of D_i, shape (N, n); powers of two where nothing else is asked
    error : E_i with |ΔM_i v|² ≲ vᵀ E_i v, shape (N, n, n): rounding and step error
    growth : ln of how far old rows have grown on the way to t_i, where that was watched, shape (N,)
    """

    method: Method
    instants: Array
    starts: Array
    matrices: Array
    units: Array
    error: Array
    growth: Array

    @property
    def is_root(self) -> bool:
        """Whether M is a square root R D, else D W D."""
        return self.method in {"square-root", "lift"}

    @property
    def n(self) -> int:
        """The number of states."""
        return int(self.matrices.shape[-1])

    def in_units(self, factors: Array) -> Gramian:
        """Return the same Gramian with the units multiplied by factors, shape (N, n)."""
        matrices = self.matrices * factors[:, None, :]
        error = self.error * factors[:, None, :] * factors[:, :, None]
        if not self.is_root:
            matrices = matrices * factors[:, :, None]
            error = error * (factors**2).max(axis=1)[:, None, None]
        return replace(self, matrices=matrices, units=self.units * factors, error=error)


def unit_diagonal(method: Method, instants: Array, start: float, W: Array, error: Array) -> Gramian:
    """Return Gramians W (N, n, n), given themselves, in units in which their diagonals are 1.

    Parameters
    ----------
    error : E in these units, shape (N, n, n); not finite where W is lost
    """
    size = diagonal_root(W)
    matrices = W / size[:, :, None] / size[:, None, :]
    lost: Flags = np.logical_not((np.isfinite(matrices) & np.isfinite(error)).all(axis=(1, 2)))
    matrices[lost], size[lost] = 0.0, 1.0
    error = np.where(lost[:, None, None], LOST * np.eye(W.shape[-1]), error)
    starts, growth = np.full(len(instants), start), np.zeros(len(instants))
    return Gramian(method, instants, starts, matrices, 1 / size, error, growth)


def squared_rounding(n: int) -> float:
    """Return ε², relative to the columns, of a factorisation or a product over n states."""
    return EPS**2 * max(1.0, n / _SMALL)


def diagonal_root(W: Array) -> Array:
    """Return √|w_jj|, 1 where it is zero, shape (N, n)."""
    size: Array = np.sqrt(np.abs(np.einsum("ijj->ij", W)))
    return np.where(size > 0, size, 1.0)
