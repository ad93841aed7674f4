"""The Gramian by its definition (2), summed over Gauss–Legendre nodes.

    W(b) = Φᵀ(a, b) W(a) Φ(a, b) + Σ_j w_j Φᵀ(τ_j, b) Hᵀ(τ_j) H(τ_j) Φ(τ_j, b)

with the transition matrices of ``transition``. Forming W squares the condition number of its root: half of
the digits are gone. Panel k leaves a random error |N_k| ≲ ε s sᵀ, s from the columns of what was summed; at
the end it is Ψᵀ N_k Ψ, Ψ = Φ(b_k, t), which moves v by ε² (vᵀ P_k v) tr P_k with P_k = Ψᵀ diag(s²) Ψ:

    |ΔW v|² ≲ ε² (vᵀ P v) tr P,    P = Σ_k P_k,    in units in which W has a unit diagonal.

References
----------
V. M. Morozov, F. Yu. Baklanov (2018), (2).
"""

from __future__ import annotations

import numpy as np

from obscli.numeric.gramian import Gramian, diagonal_root, squared_rounding, unit_diagonal
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import EPS, Array
from obscli.numeric.rates import Rates
from obscli.numeric.settings import Effort
from obscli.numeric.transition import edges_of, longest_step, panels, times


def quadrature_gramian(
    system: NumericSystem, start: float, instants: Array, rates: Rates, effort: Effort
) -> Gramian:
    """Return W(t_i, t0) at all instants; parameters and errors raised as for ``square_root_gramian``."""
    n, moving = system.n, system.moving
    W, P = np.zeros((2, n, n))
    found: list[tuple[Array, Array]] = []
    edges = edges_of(start, instants, longest_step(rates), effort.most_steps)
    with np.errstate(over="ignore", invalid="ignore"):
        for piece in panels(system, edges, effort):
            for k, (end, phi) in enumerate(zip(piece.ends, piece.transition, strict=True)):
                before = W.diagonal()
                summed = times(np.sqrt(np.maximum(before, 0.0))[None], np.abs(phi), moving)[0] ** 2
                step = before[moving] @ piece.transition_error[k] + piece.row_error[k]
                fresh = piece.rows[k].T @ piece.rows[k]
                P = _congruent(P, moving, phi) + np.diag(summed + fresh.diagonal() + step / EPS**2)
                W = _congruent(W, moving, phi) + fresh
                if end == instants[len(found)]:
                    found.append((W, P))
        whole, spread = (np.array(part) for part in zip(*found, strict=True))
        size = diagonal_root(whole)
        spread = spread / size[:, :, None] / size[:, None, :]
        trace = np.einsum("ijj->i", spread)
        error = squared_rounding(n) * trace[:, None, None] * spread
        return unit_diagonal("quadrature", instants, start, whole, error)


def _congruent(W: Array, moving: Array, transition: Array) -> Array:
    """Return Φᵀ W Φ for a symmetric W."""
    return times(times(W, transition, moving).T, transition, moving)
