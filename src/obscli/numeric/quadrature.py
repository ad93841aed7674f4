"""The Gramian by its definition (2), summed over Gauss–Legendre nodes.

    W(b) = Φᵀ(a, b) W(a) Φ(a, b) + Σ_j w_j Φᵀ(τ_j, b) Hᵀ(τ_j) H(τ_j) Φ(τ_j, b)

with the transition matrices of ``transition``. Forming W squares the condition number of its root: half of
the digits are gone, which the error says.

References
----------
V. M. Morozov, F. Yu. Baklanov (2018), (2).
"""

from __future__ import annotations

import numpy as np

from obscli.numeric.gramian import Gramian, unit_diagonal
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import EPS, Array
from obscli.numeric.rates import Rates
from obscli.numeric.settings import Effort
from obscli.numeric.transition import edges_of, longest_step, panels


def quadrature_gramian(
    system: NumericSystem, start: float, instants: Array, rates: Rates, effort: Effort
) -> Gramian:
    """Return W(t_i, t0) at all instants; parameters and errors raised as for ``square_root_gramian``."""
    W = np.zeros((system.n, system.n))
    found: list[Array] = []
    counts: list[int] = []
    count = 0
    with np.errstate(over="ignore", invalid="ignore"):
        for piece in panels(system, edges_of(start, instants, longest_step(rates)), effort):
            for end, phi, rows in zip(piece.ends, piece.transition, piece.rows, strict=True):
                W = _carried(_carried(W, system.moving, phi).T, system.moving, phi) + rows.T @ rows
                count += 1
                if end == instants[len(found)]:
                    found.append(W)
                    counts.append(count)
        spread = system.n * (EPS * np.array(counts) + effort.rtol)
        return unit_diagonal("quadrature", instants, start, np.array(found), spread)


def _carried(rows: Array, moving: Array, transition: Array) -> Array:
    """Return rows Φ(a, b); only the moving states' rows of Φ differ from those of I."""
    result = rows.copy()
    result[:, moving] = 0
    result += rows[:, moving] @ transition
    return result
