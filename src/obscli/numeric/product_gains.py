"""Singular values of a product of many matrices, each to its own relative accuracy.

Rows a_i = e^{s_i} u_i of the graded product are turned in pairs until all are orthogonal (one-sided Jacobi);
their lengths are the singular values, their directions the right singular vectors. For a pair with
ρ = e^{s_j − s_i} ≤ 1 and c = u_i·u_j, in numbers that neither overflow nor vanish:

    τ = 1/(z ± √(ρ² + z²)),   z = (1 − ρ²)/(2c),   u_i ← (u_i + ρ²τ u_j)/√(1 + ρ²τ²),   u_j ← (u_j − τ u_i)/…

References
----------
J. Demmel, K. Veselić, Jacobi's method is more accurate than QR, SIAM Journal on Matrix Analysis 13 (1992).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from obscli.numeric.matrix_product import graded, leaning
from obscli.numeric.program import EPS, Array


_SWEEPS: Final = 40


def product_gains(factors: Sequence[Array]) -> tuple[Array, Array]:
    """Return the singular values of C_K ⋯ C_1 as logarithms, the largest first, and their right vectors.

    Returns
    -------
    gains : ln γ, shape (d,)
    right : one row for each, shape (d, d)
    """
    V = leaning(factors)
    product = graded(factors, V)
    s, rows = product.s.copy(), product.U.copy()
    d = len(s)
    for _ in range(_SWEEPS):
        turned = [_turned(s, rows, i, j) for i in range(d) for j in range(i + 1, d)]
        if not any(turned):
            break
    order = np.argsort(-s)
    return s[order], rows[order] @ V.T


def _turned(s: Array, rows: Array, i: int, j: int) -> bool:
    """Make two rows orthogonal, in place; whether they were not."""
    if s[i] < s[j]:
        i, j = j, i
    c = float(rows[i] @ rows[j])
    if abs(c) <= 2 * EPS:
        return False
    rho2 = np.exp(2 * (s[j] - s[i]))
    z = (1 - rho2) / (2 * c)
    tau = 1 / (z + np.copysign(np.sqrt(rho2 + z * z), z or c))
    size = np.sqrt(1 + rho2 * tau * tau)
    turned = (rows[i] + rho2 * tau * rows[j]) / size, (rows[j] - tau * rows[i]) / size
    for k, row in zip((i, j), turned, strict=True):
        length = np.linalg.norm(row)
        s[k] += np.log(length)
        rows[k] = row / length
    return True
