"""How well a combination is known at the end, with which states its error goes together, and what limits it.

    σ² = c P cᵀ,    ρ_j = (P cᵀ)_j / (σ σ_j)

P the covariance of the Kalman filter at the end of the interval. What sets the floor is found by trying: no
driving noise, a hundredth of R, a hundredth of P0; whatever lowers σ most. As P is concave in (Q, R, P0) and
homogeneous, P(s Q, s R, s P0) = s P, one of them always lowers σ² by nearly a third or more.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from obscli.model.system import Covector, System
from obscli.numeric.finding import Floor, Knowledge
from obscli.numeric.noise import NoiseModel, continuous_noise
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import Array
from obscli.numeric.riccati import covariances, prior_of, samples_of


#: Errors less correlated than this do not go together; so many partners are named.
CORRELATED: Final = 0.5
_MOST: Final = 3

#: By how much R and P0 are made smaller to see whether they matter, as a factor of deviations.
_SMALLER: Final = 0.1


def knowledge(system: System, target: Covector, start: float, stop: float) -> Knowledge:
    """Return how well a linear form in the states is known at the end of an interval.

    Raises
    ------
    NotComputableError
        where the file has no noise of the outputs, or there are too many samples
    """
    numeric = NumericSystem(system, start, stop)
    noise = continuous_noise(numeric)
    instants, step = samples_of(system, start, stop)
    P0, assumed = prior_of(system, noise)
    root: Array = np.asarray(np.linalg.cholesky(P0), dtype=float)

    def at_end(model: NoiseModel, factor: float = 1.0) -> Array:
        return covariances(model, start, instants, step, factor * root)[-1]

    c_start, c_stop = (
        numeric.covectors([target], np.array([t]))[0][0, 0] for t in (start, float(instants[-1]))
    )
    P = at_end(noise)
    sigma = _deviation(P, c_stop)
    tried: dict[Floor, float] = {
        "R": _deviation(at_end(replace(noise, whitening=noise.whitening / _SMALLER)), c_stop),
        "P0": _deviation(at_end(noise, _SMALLER), c_stop),
    }
    if noise.drive is not None:
        tried["Q"] = _deviation(at_end(replace(noise, drive=None)), c_stop)
    return Knowledge(
        before=_deviation(P0, c_start),
        after=sigma,
        start=start,
        stop=float(instants[-1]),
        partners=_partners(system, P, c_stop, sigma, frozenset(target) if len(target) == 1 else frozenset()),
        floor=min(tried, key=lambda one: tried[one]),
        without={name: value / sigma if sigma else 1.0 for name, value in tried.items()},
        assumed=assumed,
    )


def _deviation(P: Array, c: Array) -> float:
    return float(np.sqrt(max(float(c @ P @ c), 0.0)))


def _partners(
    system: System, P: Array, c: Array, sigma: float, itself: frozenset[str]
) -> tuple[tuple[str, float], ...]:
    """Return the states whose errors go with that of the combination, the closest first."""
    variances: Array = np.diag(P).astype(float)
    size: Array = sigma * np.sqrt(variances)
    rho: Array = (P @ c) / np.where(size > 0, size, np.inf)
    found = [
        (name, float(rho[j]))
        for j, name in enumerate(system.state_names)
        if abs(rho[j]) > CORRELATED and name not in itself
    ]
    found.sort(key=lambda one: -abs(one[1]))
    return tuple(found[:_MOST])
