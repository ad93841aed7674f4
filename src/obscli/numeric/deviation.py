"""Standard deviations from information: a prior of some states, and what was learned, S with Sᵀ S.

Which directions nothing is learned of is known exactly (K, S K = 0) and not decided here. Of states p with
the prior U (P₀⁻¹ = Uᵀ U) and states n without one, S = (S_p  F):

    F = W s Xᵀ                of the rank that K leaves; W_⊥ᵀ F = 0
    S' = W_⊥ᵀ S_p             what is left tells of x_p:  Rᵀ R = Uᵀ U + S'ᵀ S'
    σ²(e) = |e_n F⁺|² + |R^(−T) (e_p − e_n F⁺ S_p)|²

infinite where e has a part along a direction of K without a component in p. F is decomposed in coordinates
of the complement of these directions, in units of its own columns. R comes from a QR factorisation with
pivoting, the largest rows first, so that a prior much wider than what is learned keeps its digits.

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

#: An entry of an orthonormal basis below this is rounding.
_ROUNDING: Final = 1e-13


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
    free, lengths = _without_prior(kernel, given)
    e_p, e_n = covectors[:, given], covectors[:, ~given]
    along = e_n * lengths
    hidden = np.linalg.norm(along @ free, axis=1) > _ZERO * np.linalg.norm(abs(along) @ abs(free), axis=1)
    triangle: Array = np.zeros((0, root.shape[1]))
    if len(root):
        triangle = np.linalg.qr(root, mode="r")  # type: ignore[assignment]  # no QRResult in this mode
    S_p, F = triangle[:, given], triangle[:, ~given]
    blind = abs(np.linalg.norm(free, axis=1) - 1) < _ZERO
    size = np.where(blind, 0.0, np.linalg.norm(F, axis=0))
    units = np.where(size > 0, size, 1.0)
    Z = _complement(free * (units * lengths)[:, None])
    Z[blind] = 0.0
    W, s, X = np.linalg.svd(F / units @ Z)
    r = len(s)
    with np.errstate(divide="ignore", invalid="ignore"):
        through = (e_n / units) @ Z @ (X[:r].T / s)
        rest = e_p - through @ (W[:, :r].T @ S_p)
        squared = (through**2).sum(axis=1) + _squared(prior[:, given], W[:, r:].T @ S_p, rest)
    return np.where(hidden | ~np.isfinite(squared), np.inf, np.sqrt(squared))


def _without_prior(kernel: Array, given: Flags) -> tuple[Array, Array]:
    """Return the directions x = D z in the kernel without a component that has a prior, and D's diagonal.

    They are an orthonormal basis in z, zero where an entry is rounding.
    """
    size = np.abs(kernel).max(axis=1, initial=0.0)
    lengths = np.where(size > 0, size, 1.0)
    unit = kernel / lengths[:, None]
    inside = unit[~given] @ _null(unit[given])
    basis, values, _ = np.linalg.svd(inside, full_matrices=False)
    return _clean(basis[:, values > _ZERO]), lengths[~given]


def _complement(columns: Array) -> Array:
    """Return an orthonormal basis of what is orthogonal to independent columns, the largest rows first."""
    order = np.argsort(-np.abs(columns).max(axis=1, initial=0.0), kind="stable")
    Q = np.zeros((len(columns), len(columns)))
    Q[order] = qr(columns[order], pivoting=True)[0]
    return Q[:, columns.shape[1] :]


def _clean(basis: Array) -> Array:
    """Return an orthonormal basis with the rounding in its zeros taken away."""
    cleaned: Array = np.where(np.abs(basis) > _ROUNDING, basis, 0.0)
    return cleaned


def _null(matrix: Array) -> Array:
    """Return an orthonormal basis of the kernel, columns."""
    _, values, right = np.linalg.svd(matrix)
    rank = int((values > _ZERO * values.max(initial=0.0)).sum())
    return _clean(right[rank:].T)


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
