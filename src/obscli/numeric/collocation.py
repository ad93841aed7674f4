"""Gauss–Legendre collocation on [0, 1]: nodes, weights and the integrals of a polynomial through its nodes.

With nodes x_j and weights w_j, for a polynomial g of degree < s:

    ∫_x_j^1 g = Σ_l B_jl g(x_l),    ∫_0^1 g = Σ_l w_l g(x_l),    g = Σ_k (C g)_k P_k(2x − 1)

References
----------
E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, II.1 (collocation methods).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre

from obscli.numeric.program import Array


@dataclass(frozen=True, slots=True, eq=False)
class Collocation:
    """The s-node rule: ``nodes`` (s,), ``weights`` (s,), ``backward`` B (s, s), ``spectrum`` C (s, s)."""

    nodes: Array
    weights: Array
    backward: Array
    spectrum: Array

    @property
    def forward(self) -> Array:
        """∫_0^x_j g = Σ_l (w_l − B_jl) g(x_l), shape (s, s)."""
        return self.weights - self.backward


@lru_cache(maxsize=8)
def gauss_legendre(s: int) -> Collocation:
    """Return the rule with s nodes."""
    u, w = legendre.leggauss(s)
    P = legendre.legvander(u, s)
    k = np.arange(s)
    spectrum = (2 * k[:, None] + 1) / 2 * w * P[:, :s].T
    integrals = np.empty((s, s))
    integrals[:, 0] = 1 - u
    integrals[:, 1:] = (P[:, : s - 1] - P[:, 2:]) / (2 * k[1:] + 1)  # ∫_u^1 P_k = (P_{k−1} − P_{k+1})/(2k+1)
    return Collocation((u + 1) / 2, w / 2, integrals @ spectrum / 2, spectrum)
