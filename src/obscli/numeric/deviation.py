"""Standard deviations from information: a prior of some states, and what was learned, S with Sᵀ S.

Of states p with the prior U (P₀⁻¹ = Uᵀ U) and states n without one, S = (S_p  F):

    F = W s Xᵀ                what is learned fixes x_n up to the kernel of F, decided in units of its columns
    S' = W_⊥ᵀ S_p U⁻¹         what is left tells of x_p:  P_p = L Lᵀ,  L = U⁻¹ V (1 + σ²)^(−1/2),  S' = · σ Vᵀ
    σ²(e) = |e_n F⁺|² + |(e_p − e_n F⁺ S_p) L|²

infinite where e_n has a part in the kernel of F. A prior is never weighed against what is learned in a
decision, so that learning more makes no deviation larger.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from obscli.numeric.program import Array, Flags


#: A direction of F is unseen below this, relative to the largest, in units of its columns.
_ZERO: Final = 1e-11

#: A form has a part in the kernel above this, relative to the sizes of the terms that would cancel.
_LEAK: Final = 1e-6


def deviations(prior: Array, root: Array, covectors: Array) -> Array:
    """Return the standard deviation of linear forms, shape (k,).

    Parameters
    ----------
    prior : rows U with Uᵀ U the information on the states that have a prior, zero in the others, shape (p, n)
    root : rows S, shape (r, n)
    covectors : shape (k, n)
    """
    n = covectors.shape[1]
    given: Flags = (prior != 0).any(axis=0)
    triangle: Array = np.zeros((0, n))
    if len(root):
        triangle = np.linalg.qr(root, mode="r")  # type: ignore[assignment]  # no QRResult in this mode
    S_p, F = triangle[:, given], triangle[:, ~given]
    e_p, e_n = covectors[:, given], covectors[:, ~given]
    size = np.linalg.norm(F, axis=0)
    units = np.where(size > 0, size, 1.0)
    W, s, X = np.linalg.svd(F / units)
    r = int((s > _ZERO * s.max(initial=0.0)).sum())
    kernel = X[r:] / units
    hidden = np.linalg.norm(e_n @ kernel.T, axis=1) > _LEAK * np.linalg.norm(abs(e_n) @ abs(kernel.T), axis=1)
    through = (e_n / units) @ (X[:r].T / s[:r])
    rest = e_p - through @ (W[:, :r].T @ S_p)
    L = _prior_root(prior[:, given], W[:, r:].T @ S_p)
    deviation = np.sqrt((through**2).sum(axis=1) + ((rest @ L) ** 2).sum(axis=1))
    return np.where(hidden, np.inf, deviation)


def _prior_root(U: Array, S: Array) -> Array:
    """Return L with L Lᵀ = (Uᵀ U + Sᵀ S)⁻¹, shape (p, p)."""
    inverse = np.linalg.inv(U) if len(U) else np.zeros((0, 0))
    _, sigma, V = np.linalg.svd(S @ inverse)
    weights = np.ones(len(V))
    weights[: len(sigma)] = 1 / np.sqrt(1 + sigma**2)
    root: Array = (inverse @ V.T) * weights
    return root
