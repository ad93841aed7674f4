"""The information of all samples on the state, without a prior: what the Cramér–Rao bound is made of.

    between samples   S ← S Φ(a, b), driving noise eliminated          at a sample   S ← (S; R^(−½) H)

SᵀS = J is the Fisher information on x(t); no unbiased estimate from the samples alone has a covariance below
J⁻¹. Where nothing is seen, S has a kernel, which is known exactly and not decided here.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from obscli.model.system import System
from obscli.numeric.errors import NotComputableError
from obscli.numeric.hidden_motion import transitions
from obscli.numeric.information import driven, triangle
from obscli.numeric.noise import noise_model
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import Array, Flags
from obscli.numeric.rates import rates_of
from obscli.numeric.riccati import MOST_PHASE, driving_rate, entering
from obscli.numeric.schedule import Schedule
from obscli.numeric.settings import Effort
from obscli.numeric.transition import edges_of, longest_step


_STEP_ERROR: Final = 1e-12
_MOST: Final = 100_000
_PROBES: Final = 18

#: Rows are triangularised when they are more than so many per state.
_GATHERED: Final = 4


def information_roots(system: System, schedule: Schedule, instants: Array) -> list[Array]:
    """Return S with SᵀS the information on the state at instants in order, after their samples.

    Parameters
    ----------
    schedule : what is sampled when, from its start
    instants : shape (k,), not before the start

    Raises
    ------
    NotComputableError
        where the noise of an output is not given, the steps are too many, or a state decays too far
    """
    numeric = NumericSystem(system, schedule.start, schedule.stop)
    noise = noise_model(numeric)
    last = float(instants[-1])
    taken: Flags = schedule.t <= last
    times, sampled = schedule.t[taken], schedule.sampled[taken]
    rows = dict(zip(times.tolist(), _whitened(numeric, schedule.R, times, sampled), strict=True))
    root = rows.get(schedule.start, np.zeros((0, system.n)))
    found = [root] if instants[0] == schedule.start else []
    stops = np.union1d(times, instants)
    stops = stops[stops > schedule.start]
    if not len(stops):
        return found
    rates = rates_of(numeric, np.linspace(schedule.start, last, _PROBES)[1:-1])
    longest = min(longest_step(rates), MOST_PHASE / max(driving_rate(noise, stops), 1e-300))
    edges = edges_of(schedule.start, stops, longest, _MOST)
    noises = entering(noise, edges)
    edges = np.union1d(edges, list(noises))
    for phi, end in transitions(numeric, edges, Effort(_STEP_ERROR, _MOST)):
        root = root @ phi
        if end in noises:
            root = driven(root, noises[end])
        if end in rows:
            root = np.concatenate([root, rows[end]])
        if len(root) > _GATHERED * system.n:
            root = triangle(root)
        if len(found) < len(instants) and end == instants[len(found)]:
            found.append(_finite(triangle(root), end))
    return found


def _whitened(numeric: NumericSystem, R: Array, times: Array, sampled: Flags) -> list[Array]:
    """Return R^(−½) H of what is sampled at each instant."""
    outputs = numeric.matrices(times)[1] if len(times) else np.zeros((0, numeric.m, numeric.n))
    roots: dict[bytes, Array] = {}
    found = []
    for H, which in zip(outputs, sampled, strict=True):
        key = which.tobytes()
        if key not in roots:
            roots[key] = np.asarray(np.linalg.inv(np.linalg.cholesky(R[np.ix_(which, which)])), dtype=float)
        found.append(roots[key] @ H[which])
    return found


def _finite(root: Array, t: float) -> Array:
    if not np.isfinite(root).all():
        raise NotComputableError(
            f"the information overflows at {t:.6g}: a state decays too far; give a shorter interval (--to)"
        )
    return root
