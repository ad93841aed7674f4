"""A system with its samples and noise in numbers, panel by panel, in coordinates of the start of each panel.

On a panel [a, b] with z = x(a) as it is known at t: x(t) = Φ(t, a) z. Nothing moves z but driving noise and
samples, so that without driving noise all samples of a panel are of one constant z:

    y = H(t) Φ(t, a) z + v
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Final

import numpy as np

from obscli.core.number import bar
from obscli.model.system import System
from obscli.numeric.dense_transition import DenseTransition, dense_transitions
from obscli.numeric.discrete_steps import require_whole, single_steps, steps_between
from obscli.numeric.driving_noise import driven_states, driving_rate, noise_roots
from obscli.numeric.errors import NotComputableError
from obscli.numeric.noise import noise_model
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import Array, Counts, Flags
from obscli.numeric.rates import rates_of
from obscli.numeric.reach import reach
from obscli.numeric.schedule import Schedule
from obscli.numeric.settings import Effort
from obscli.numeric.transition import edges_of, longest_step, panels, times


_STEP_ERROR: Final = 1e-13
_MOST_PANELS: Final = 200_000
_PROBES: Final = 18

#: An interval has at least so many panels: instants to record also where nothing is sampled.
_FEWEST: Final = 64

#: A panel holds no more samples than so many, or thereabouts: what is computed at all of them takes memory.
_AT_ONCE: Final = 1000

#: An edge of a panel moves to a sample that is nearer than this share of the panel.
_NEAR: Final = 0.125

#: Instants closer than this, relative to the steps, are one.
_SAME: Final = 1e-9

#: G turns by no more than this within a panel, in radians.
_MOST_PHASE: Final = 1.5


@dataclass(frozen=True, slots=True, eq=False)
class Timeline:
    """Panels that several systems share, and the instants at which something is sampled or a panel ends.

    ``edges`` of the panels; ``t``: start, samples and edges, (k,); ``sample``: which sample of the schedule
    is taken then, −1: none, (k,).
    """

    edges: Array
    t: Array
    sample: Counts

    def including(self, instants: Array) -> tuple[Timeline, Counts]:
        """Return a timeline with more instants, and their places in it; those that agree to rounding are one.

        Raises
        ------
        NotComputableError
            where an instant is not within the interval
        """
        after = np.clip(np.searchsorted(self.t, instants), 1, len(self.t) - 1)
        near = _SAME * float(np.median(np.diff(self.t)))
        known = np.where(self.t[after] - instants < instants - self.t[after - 1], after, after - 1)
        snapped = np.where(np.abs(self.t[known] - instants) <= near, self.t[known], instants)
        outside = (snapped < self.t[0]) | (snapped > self.t[-1])
        if outside.any():
            raise NotComputableError(
                f"{snapped[outside][0]:.6g} is not within {self.t[0]:.6g} to {self.t[-1]:.6g} (--from, --to)"
            )
        t = np.union1d(self.t, snapped)
        sample = np.full(len(t), -1)
        sample[np.searchsorted(t, self.t)] = self.sample
        return Timeline(self.edges, t, sample), np.searchsorted(t, snapped)

    def progress(self, k: int) -> str:
        """Say how far one has come at an instant: a bar of what is done, and the time."""
        return f"{bar(k, len(self.t) - 1)} instants, t = {self.t[k]:.6g} of {self.t[-1]:.6g}"

    def marks(self, most: int) -> Flags:
        """Return which instants are recorded: start, stop, samples, ends of panels where nothing is sampled.

        No more than ``most``, at least 2: those nearest to an even grid.
        """
        taken = self.sample >= 0
        taken[[0, -1]] = True
        at = np.flatnonzero(taken)
        gaps = np.diff(self.t[at])
        for k in np.flatnonzero(gaps > max(3 * float(np.median(gaps)), np.ptp(self.t) / most)):
            taken[at[k] : at[k + 1]] = True
        at = np.flatnonzero(taken)
        if len(at) > most:
            grid = np.linspace(self.t[0], self.t[-1], max(most, 2))
            after = np.clip(np.searchsorted(self.t[at], grid), 1, len(at) - 1)
            nearer = self.t[at[after]] - grid > grid - self.t[at[after - 1]]
            taken = np.zeros_like(taken)
            taken[at[after - nearer]] = True
        return taken


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """One panel of one system.

    Parameters
    ----------
    first : index of its first instant in the timeline
    transition : Φ(t, a) at its k instants, the last of them its end, shape (k, n, n)
    rows : H(t) Φ(t, a), shape (k, m, n)
    noise : square roots of the driving noise since the instant before, shape (k, n, r); None: nothing drives
    step : F, which takes the coordinates of this panel to those of the next, (n, n); None: Φ at its end
    """

    first: int
    transition: Array
    rows: Array
    noise: Array | None
    step: Array | None = None

    @property
    def onward(self) -> Array:
        """What takes the coordinates of the panel to those of the next, shape (n, n)."""
        return self.transition[-1] if self.step is None else self.step


class SampledSystem:
    """A system in floating point with its schedule.

    Raises
    ------
    NotComputableError
        where noise is not given; the text says what to give
    """

    def __init__(self, system: System, schedule: Schedule) -> None:
        self.numeric = NumericSystem(system, schedule.start, schedule.stop)
        self.noise = noise_model(self.numeric)
        self.schedule = schedule
        start = np.array([schedule.start])
        self.reach = reach(system)
        self._driven = self.reach @ driven_states(self.noise)
        self._constant_outputs = self.numeric.matrices(start)[1] if self.numeric.is_constant else None

    @property
    def prior(self) -> Array:
        """A square root of P0, shape (n, n).

        Raises
        ------
        NotComputableError
            where a state has no P0
        """
        names = self.numeric.system.state_names
        missing = [s for s, p in zip(names, np.diag(self.noise.P0), strict=True) if p == 0]
        if missing:
            raise NotComputableError(
                f"no initial deviation of {', '.join(missing)}: give `noise: {{P0_std: {{{missing[0]}: …}}}}`"
                f"{'' if len(missing) == 1 else ', for each of them'}"
            )
        return np.asarray(np.linalg.cholesky(self.noise.P0), dtype=float)

    @property
    def drives(self) -> bool:
        """Whether noise drives the states."""
        return self.noise.drive is not None

    def longest(self) -> float:
        """Return the longest panel that the dynamics and G allow."""
        t = np.linspace(self.schedule.start, self.schedule.stop, _PROBES)[1:-1]
        rate = driving_rate(self.noise, t)
        return min(longest_step(rates_of(self.numeric, t)), _MOST_PHASE / rate if rate else np.inf)

    def stretches(self, timeline: Timeline) -> Iterator[Stretch]:
        """Yield the panels in order; the first one has the start among its instants."""
        if self.numeric.system.discrete:
            yield from self._steps(timeline)
            return
        ends = np.searchsorted(timeline.t, timeline.edges, side="right")
        first = 0
        for dense, last in zip(dense_transitions(self.numeric, timeline.edges), ends[1:], strict=True):
            t = timeline.t[first:last]
            before = np.concatenate([[max(dense.start, timeline.t[max(first - 1, 0)])], t])
            moving = dense.forward(t)
            transition = np.tile(np.eye(self.numeric.n), (len(t), 1, 1))
            transition[:, dense.moving] = moving
            rows = times(self._outputs(t), moving, dense.moving)
            yield Stretch(first, transition, rows, self._roots(dense, before))
            first = last

    def _steps(self, timeline: Timeline) -> Iterator[Stretch]:
        """Yield the steps of a discrete-time system, each as a panel of its own; the last leads nowhere."""
        here, last = np.eye(self.numeric.n)[None], len(timeline.t) - 1
        for k, F, H, entered in single_steps(self.numeric, self.noise, timeline.t):
            noise = None if entered is None else entered[None]
            yield Stretch(k, here, H[None], noise, None if k == last else F)

    def _roots(self, dense: DenseTransition, t: Array) -> Array | None:
        """Return the square roots of the noise of steps, zero in the states that it does not reach."""
        found = noise_roots(self.noise, dense, t)
        if found is not None:
            found[:, ~self._driven] = 0.0
        return found

    def _outputs(self, t: Array) -> Array:
        """Return H at k instants, shape (k, m, n), or (1, m, n) where nothing varies."""
        return self.numeric.matrices(t)[1] if self._constant_outputs is None else self._constant_outputs

    def whitening(self, sample: Counts) -> Array:
        """Return W with W R Wᵀ = I on the outputs sampled, zero elsewhere, shape (k, m, m); −1: no sample."""
        sampled = self.schedule.sampled[sample] & (sample >= 0)[:, None]
        patterns, which = np.unique(sampled, axis=0, return_inverse=True)
        return np.array([_whitened(self.schedule.R, one) for one in patterns])[which.ravel()]


def timeline_of(systems: Sequence[SampledSystem], schedule: Schedule) -> Timeline:
    """Return panels on which all systems are resolved, and the instants of the schedule on them."""
    start, stop = schedule.start, schedule.stop
    if systems[0].numeric.system.discrete:
        return _step_by_step(schedule)
    fewest = max(_FEWEST, len(schedule.t) // _AT_ONCE)
    systems = list(dict.fromkeys(systems))
    longest = min(*(one.longest() for one in systems), (stop - start) / fewest)
    edges = _moved_to(schedule.t, edges_of(start, np.array([stop]), longest, _MOST_PANELS))
    effort = Effort(_STEP_ERROR, 2 * _MOST_PANELS)
    for one in systems:
        edges = np.concatenate([[start], *(piece.ends for piece in panels(one.numeric, edges, effort))])
    t = reduce(np.union1d, [schedule.t, edges])
    sample = np.full(len(t), -1)
    sample[np.searchsorted(t, schedule.t)] = np.arange(len(schedule.t))
    return Timeline(edges, t, sample)


def _step_by_step(schedule: Schedule) -> Timeline:
    """Return every step as an instant, and as an edge."""
    t = steps_between(schedule.start, schedule.stop)
    require_whole(schedule.t)
    sample = np.full(len(t), -1)
    sample[np.round(schedule.t - schedule.start).astype(int)] = np.arange(len(schedule.t))
    return Timeline(t, t, sample)


def _moved_to(samples: Array, edges: Array) -> Array:
    """Return edges, those that are near a sample moved to it."""
    after = np.clip(np.searchsorted(samples, edges), 1, max(len(samples) - 1, 1))
    nearest = samples[np.clip(np.stack([after - 1, after]), 0, len(samples) - 1)]
    nearest = nearest[np.abs(nearest - edges).argmin(axis=0), np.arange(len(edges))]
    near = np.abs(nearest - edges) < _NEAR * np.diff(edges).min()
    near[[0, -1]] = False
    return np.unique(np.where(near, nearest, edges))


def _whitened(R: Array, sampled: Flags) -> Array:
    """Return the inverse Cholesky factor of the part of R that is sampled, in its place, shape (m, m)."""
    found = np.zeros_like(R)
    at = np.flatnonzero(sampled)
    found[np.ix_(at, at)] = np.linalg.inv(np.linalg.cholesky(R[np.ix_(at, at)]))
    return found
