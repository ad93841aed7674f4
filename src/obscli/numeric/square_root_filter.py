"""One step of the Kalman filter in square-root form, P = L Lᵀ, outputs in units of their noise (R = I).

With driving noise M Mᵀ, then outputs of rows B:

    (I  B L  B M)      (S^½  0   0)
    (0    L    M)  =   (K̄    L⁺  0) Q',      S = I + B P⁻ Bᵀ,   K = K̄ S^−½

Without driving noise, all outputs B of a constant state together:

    (B L)
    ( I )  = Q T,    L⁺ = L T⁻¹:    P⁺ = L (I + Lᵀ Bᵀ B L)⁻¹ Lᵀ

Nothing is subtracted, so no variance becomes negative, and what no output shows keeps its prior.

References
----------
M. S. Grewal, A. P. Andrews, Kalman Filtering (2008), 6.5 (square-root filters).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from scipy.linalg.lapack import dgeqrf, dtrtrs

from obscli.numeric.errors import NotComputableError
from obscli.numeric.program import Array


def measured(root: Array, rows: Array, noise: Array | None = None) -> tuple[Array, Array, Array]:
    """Return L⁺ (n, n), S^½ (m, m), lower triangular, and K̄ (n, m).

    Parameters
    ----------
    root : L, shape (n, n)
    rows : B, shape (m, n)
    noise : M, shape (n, r); None: none since the outputs before
    """
    m, n = rows.shape
    both = root if noise is None else np.concatenate([root, noise], axis=1)
    columns = both.shape[1]
    joint = np.zeros((m + columns, m + n), order="F")
    joint[np.arange(m), np.arange(m)] = 1.0
    joint[m:, :m] = (rows @ both).T
    joint[m:, m:] = both.T
    triangle = _triangle(joint)
    return triangle[m:, m:].T, triangle[:m, :m].T, triangle[:m, m:].T


def informed(root: Array, rows: Array) -> Array:
    """Return L⁺ after outputs of rows B, shape (k, n), of a state that nothing drives."""
    n = root.shape[1]
    joint = np.concatenate([rows @ root, np.eye(n)])
    found, _ = dtrtrs(_triangle(np.asfortranarray(joint)), root.T, trans=1)  # T has no zero: TᵀT ≥ I
    result: Array = found.T
    return result


def compressed(parts: Sequence[Array]) -> Array:
    """Return a lower triangular L, shape (n, n), with L Lᵀ the sum over parts (n, …) of M Mᵀ."""
    columns = np.concatenate(parts, axis=1)
    n, k = columns.shape
    joint = np.zeros((max(n, k), n), order="F")
    joint[:k] = columns.T
    return _triangle(joint).T


def refuse_infinite(t: float, *roots: Array) -> None:
    """Refuse square roots that are beyond all numbers at an instant."""
    if not all(np.isfinite(one).all() for one in roots):
        raise NotComputableError(
            f"the covariance is beyond all numbers at {t:.6g}: choose a shorter interval (--to)"
        )


def _triangle(rows: Array) -> Array:
    """Return R of the factorisation Q R, shape (n, n); rows (k, n), k ≥ n, are overwritten."""
    found, _, _, _ = dgeqrf(rows, overwrite_a=1)
    n = rows.shape[1]
    upper: Array = found[:n] * _upper(n)
    return upper


@lru_cache(maxsize=16)
def _upper(n: int) -> Array:
    """Ones on and above the diagonal, shape (n, n)."""
    return np.triu(np.ones((n, n)))
