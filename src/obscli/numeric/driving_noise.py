"""Driving noise of steps within a panel, in coordinates of the panel's start, as square roots.

    M Mᵀ = ∫ Φ(a, σ) G Q Gᵀ Φ(a, σ)ᵀ dσ    over the step,    M = (√(h w_j) Φ(a, σ_j) G Q^½)_j

by Gauss–Legendre, with as many nodes as make the error of the step smaller than rounding: short steps within
a long panel take few.

References
----------
C. F. Van Loan, Computing integrals involving the matrix exponential, IEEE Trans. AC 23 (1978): the integral
for constant systems.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from math import factorial
from typing import Final

import numpy as np

from obscli.numeric.collocation import gauss_legendre
from obscli.numeric.dense_transition import DenseTransition
from obscli.numeric.errors import NotComputableError
from obscli.numeric.noise import NoiseModel
from obscli.numeric.program import Array, Flags, Program
from obscli.numeric.rates import argument_derivatives


#: By how much the integrand may turn or grow over a whole panel: twice what Φ and G do, at the most; and the
#: error of one step, relative to its noise.
_TURN: Final = 6.0
_SMALL: Final = 1e-14
_MOST_NODES: Final = 12


def noise_roots(noise: NoiseModel, dense: DenseTransition, t: Array) -> Array | None:
    """Return the square roots M of the noise of steps, shape (k, n, r); None: nothing drives.

    Parameters
    ----------
    t : the edges of the steps, within the panel, shape (k + 1,)

    Raises
    ------
    NotComputableError
        where G does not exist at some instant
    """
    if noise.drive is None:
        return None
    h = np.diff(t)
    rule = gauss_legendre(_nodes_for(float(h.max()) / (dense.stop - dense.start)))
    instants = (t[:-1, None] + h[:, None] * rule.nodes).ravel()
    driven = noise.driving(instants)[:, :, np.abs(noise.drive).any(axis=0)]
    if not np.isfinite(driven).all():
        raise NotComputableError(f"G does not exist at some instant from {t[0]:.6g} to {t[-1]:.6g}")
    moved = driven.copy()
    moved[:, dense.moving] = dense.backward(instants) @ driven
    moved *= np.sqrt(h[:, None] * rule.weights).reshape(-1, 1, 1)
    k, (n, d) = len(h), moved.shape[1:]
    roots = moved.reshape(k, -1, n, d).swapaxes(1, 2).reshape(k, n, -1)
    if roots.shape[2] <= n:
        return roots
    triangles: Array = np.linalg.qr(roots.swapaxes(1, 2), mode="r")  # type: ignore[assignment]  # no QRResult here
    return triangles.swapaxes(1, 2)


def driven_states(noise: NoiseModel) -> Flags:
    """Return which states noise enters directly, shape (n,)."""
    system = noise.system.system
    found = np.zeros(system.n, dtype=bool)
    if noise.drive is not None and system.noise is not None and system.noise.driven == "states":
        found[np.abs(noise.drive).any(axis=1)] = True
    elif noise.drive is not None and system.G is not None:
        found[[i for i, _ in system.G.entries]] = True
    return found


def driving_rate(noise: NoiseModel, t: Array) -> float:
    """Return how fast arguments of sin, cos, … in G vary, as seen at some instants."""
    system = noise.system.system
    if noise.drive is None or system.G is None:
        return 0.0
    derivatives = argument_derivatives(replace(system, A=system.G))
    found = Program(derivatives).run(noise.system.values(t, {}))
    return max((float(np.abs(one).max()) for one in found), default=0.0)


@lru_cache(maxsize=64)
def _nodes_for(share: float) -> int:
    """Return how many nodes a step of this share of its panel takes: the error of Gauss's rule is small."""
    for p in range(2, _MOST_NODES):
        error = (_TURN * share) ** (2 * p) * factorial(p) ** 4 / ((2 * p + 1) * factorial(2 * p) ** 3)
        if error < _SMALL:
            return p
    return _MOST_NODES
