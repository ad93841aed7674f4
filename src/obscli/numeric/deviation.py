"""Standard deviations from information: a prior of some states, and what was learned, S with Sᵀ S.

Which directions nothing is learned of is known exactly (K, S K = 0) and not decided here. Of states p with
the prior U (P₀⁻¹ = Uᵀ U) and states n without one, S = (S_p  F):

    F = W s Xᵀ                of the rank that K leaves; W_⊥ᵀ F = 0
    S' = W_⊥ᵀ S_p             what is left tells of x_p:  Rᵀ R = Uᵀ U + S'ᵀ S'
    σ²(e) = |e_n F⁺|² + |R^(−T) (e_p − e_n F⁺ S_p)|²

infinite where e has a part along a direction of K without a component in p. R comes from a QR factorisation
with pivoting, the largest rows first, so that a prior much wider than what is learned keeps its digits.

References
----------
A. J. Cox, N. J. Higham, Stability of Householder QR factorization for weighted least squares (1998).
"""

from __future__ import annotations

from typing import Final

import numpy as np
from scipy.linalg import qr, solve_triangular

from obscli.numeric.program import Array, Flags


#: Exact rows and directions evaluated in floating point are zero below this, relative to their terms.
_ZERO: Final = 1e-9


def unseen(rows: Array) -> Array:
    """Return a basis K of the directions along which linear forms do not change, columns, shape (n, q).

    Parameters
    ----------
    rows : the forms, evaluated from exact ones, shape (r, n)
    """
    columns = np.abs(rows).max(axis=0, initial=0.0)
    units = np.where(columns > 0, columns, 1.0)
    scaled = rows / units
    largest = np.abs(scaled).max(axis=1, initial=0.0)[:, None]
    kernel: Array = _null(scaled / np.where(largest > 0, largest, 1.0)) / units[:, None]
    return kernel


def deviations(prior: Array, root: Array, covectors: Array, kernel: Array) -> Array:
    """Return the standard deviation of linear forms, shape (k,).

    Parameters
    ----------
    prior : rows U with Uᵀ U the information on the states that have a prior, zero in the others, shape (p, n)
    root : rows S, shape (r, n)
    covectors : shape (k, n)
    kernel : directions that S does not see, known exactly, shape (n, q)
    """
    given: Flags = (prior != 0).any(axis=0)
    free = _without_prior(kernel, given)
    e_p, e_n = covectors[:, given], covectors[:, ~given]
    hidden = np.linalg.norm(e_n @ free, axis=1) > _ZERO * np.linalg.norm(abs(e_n) @ abs(free), axis=1)
    triangle: Array = np.zeros((0, root.shape[1]))
    if len(root):
        triangle = np.linalg.qr(root, mode="r")  # type: ignore[assignment]  # no QRResult in this mode
    S_p, F = triangle[:, given], triangle[:, ~given]
    F = F - (F @ free) @ free.T  # rounding along what is known not to be seen
    size = np.linalg.norm(F, axis=0)
    units = np.where(size > 0, size, 1.0)
    W, s, X = np.linalg.svd(F / units)
    r = min(F.shape[1] - free.shape[1], len(s))
    with np.errstate(divide="ignore", invalid="ignore"):
        through = (e_n / units) @ (X[:r].T / s[:r])
        rest = e_p - through @ (W[:, :r].T @ S_p)
        squared = (through**2).sum(axis=1) + _squared(prior[:, given], W[:, r:].T @ S_p, rest)
    return np.where(hidden | ~np.isfinite(squared), np.inf, np.sqrt(squared))


def _without_prior(kernel: Array, given: Flags) -> Array:
    """Return an orthonormal basis of the directions in the kernel without a component that has a prior."""
    size = np.linalg.norm(kernel, axis=0)
    unit = kernel / np.where(size > 0, size, 1.0)
    inside = unit[~given] @ _null(unit[given])
    basis, values, _ = np.linalg.svd(inside, full_matrices=False)
    orthonormal: Array = basis[:, values > _ZERO]
    return orthonormal


def _null(matrix: Array) -> Array:
    """Return an orthonormal basis of the kernel, columns."""
    _, values, right = np.linalg.svd(matrix)
    rank = int((values > _ZERO * values.max(initial=0.0)).sum())
    kernel: Array = right[rank:].T
    return kernel


def _squared(U: Array, S: Array, forms: Array) -> Array:
    """Return |R^(−T) e|² for forms e (k, p), Rᵀ R = Uᵀ U + Sᵀ S, shape (k,)."""
    if not len(U):
        return np.zeros(len(forms))
    rows = np.concatenate([S, U])
    order = np.argsort(-np.abs(rows).max(axis=1), kind="stable")
    R, pivots = qr(rows[order], mode="r", pivoting=True)
    p = rows.shape[1]
    found = solve_triangular(R[:p], forms[:, pivots].T, trans="T")
    squared: Array = (found**2).sum(axis=0)
    return squared
