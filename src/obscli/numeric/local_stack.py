"""The observability matrix of a window: what its samples, or the derivatives at its start, show of x(t_i).

    discrete, frozen      R = [H; H Φ; …; H Φ^(N−1)],   Φ = exp(A(t_i) h)
    discrete, true        R = [H(t_i); H(t_i + h) Φ(t_i + h, t_i); …]
    continuous, frozen    R = [H; H A; …; H A^(N−1)]

All windows at once. With every stack goes what rounding may have made of it,

    ΔR_{j+1} = ΔR_j |F| + |R_j| ΔF,

so that a rank is judged by what it may be wrong by, not by a threshold.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

import numpy as np

from obscli.numeric.gramian import Gramian, squared_rounding
from obscli.numeric.matrix_exponential import exponentials
from obscli.numeric.numeric_system import Coefficients
from obscli.numeric.program import EPS, Array


#: Samples of the outputs, or their derivatives at the start.
Form: TypeAlias = Literal["discrete", "continuous"]

#: An exponential is off by so many roundings of its entries.
_EXPONENTIAL: Final = 4.0


@dataclass(frozen=True, slots=True, eq=False)
class LocalStack:
    """R of k windows by blocks, shape (k, N, m, n), and its error, entry by entry."""

    rows: Array
    error: Array

    def weighed(self, weights: Array) -> LocalStack:
        """Return the stack with its blocks multiplied from the left, weights (m, m) or (…, N, m, m)."""
        return LocalStack(weights @ self.rows, np.abs(weights) @ self.error)

    def triangle(self, starts: Array, stops: Array, units: Array) -> Gramian:
        """Return a triangular T with TᵀT = D RᵀR D as the root of a Gramian, x = D z; units D (n,)."""
        k, N, m, n = self.rows.shape
        flat = (self.rows * units).reshape(k, N * m, n)
        root = np.zeros((k, n, n))
        root[:, : min(N * m, n)] = np.linalg.qr(flat, mode="r") if N * m > n else flat
        squared = ((self.error * units) ** 2).sum(axis=(1, 2))
        squared += squared_rounding(n) * (flat**2).sum(axis=1)
        error = squared[:, :, None] * np.eye(n)
        return Gramian("square-root", stops, starts, root, np.broadcast_to(units, (k, n)), error, np.zeros(k))


def frozen_stack(found: Coefficients, moving: Array, form: Form, count: int, h: float) -> LocalStack:
    """Return the stack of windows in which A and H keep the values of their starts.

    Parameters
    ----------
    found : A's moving rows (k, p, n) and H (k, m, n) at the starts, with their errors
    count : N
    h : time between samples; with derivatives the factor of A, 1 for A itself
    """
    A, n = found.A, found.A.shape[2]
    if form == "continuous":
        F, error = (
            _full(h * A, moving, n, identity=False),
            _full(h * found.A_error, moving, n, identity=False),
        )
    else:
        F = _full(exponentials(A, moving, h), moving, n, identity=True)
        moved = _full(_EXPONENTIAL * EPS * np.abs(F[:, moving]), moving, n, identity=False)
        error = moved + np.abs(F) @ _full(h * found.A_error, moving, n, identity=False)
    k, m = found.H.shape[:2]
    rows, errors = np.empty((k, count, m, n)), np.empty((k, count, m, n))
    rows[:, 0], errors[:, 0] = found.H, found.H_error
    for j in range(1, count):
        rows[:, j] = rows[:, j - 1] @ F
        size = np.abs(rows[:, j - 1])
        errors[:, j] = errors[:, j - 1] @ np.abs(F) + size @ (error + EPS * np.abs(F))
    return LocalStack(rows, errors)


def true_stack(H: Array, H_error: Array, steps: Array, steps_error: Array) -> LocalStack:
    """Return the stack of windows along which A and H vary.

    Parameters
    ----------
    H : at the samples of every window, shape (k, N, m, n); its error likewise
    steps : Φ(t_{j+1}, t_j) between the samples, shape (k, N − 1, n, n); their error likewise
    """
    k, N, _, n = H.shape
    phi = np.broadcast_to(np.eye(n), (k, n, n))
    moved = np.zeros((k, n, n))
    rows, errors = np.empty_like(H), np.empty_like(H)
    rows[:, 0], errors[:, 0] = H[:, 0], H_error[:, 0]
    for j in range(1, N):
        step, size = steps[:, j - 1], np.abs(steps[:, j - 1])
        moved = size @ moved + (steps_error[:, j - 1] + EPS * size) @ np.abs(phi)
        phi = step @ phi
        rows[:, j] = H[:, j] @ phi
        errors[:, j] = H_error[:, j] @ np.abs(phi) + np.abs(H[:, j]) @ (moved + EPS * np.abs(phi))
    return LocalStack(rows, errors)


def _full(rows: Array, moving: Array, n: int, *, identity: bool) -> Array:
    """Return square matrices of their moving rows; the others are zero, or those of I."""
    found = np.zeros((len(rows), n, n))
    if identity:
        found[:] = np.eye(n)
    found[:, moving] = rows
    return found
