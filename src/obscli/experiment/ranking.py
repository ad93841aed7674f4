"""Sets of runs ranked by what matters: whether requirements are met, how long it takes, by what margin."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from obscli.core.number import bar
from obscli.exact.row_sets import RowSets
from obscli.experiment.durations import Durations, shortest
from obscli.experiment.informed import Informed
from obscli.experiment.limits import MOST_ADDED
from obscli.experiment.stacked import Progress


#: Sets whose durations are shortened.
SHORTENED: Final = 12

#: Sets whose margins are looked at; of more, so many, of which the best are improved. So often it is told.
MOST_RANKED: Final = 4000
IMPROVED: Final = 3
_TOLD: Final = 100

#: An infinite deviation is this many times too large.
_HOPELESS: Final = 1e12


@dataclass(frozen=True, slots=True)
class RankedSet:
    """One set of runs by index: how long it takes with setting up, and its worst margin where that is known.

    ``shortest``: the shortest durations that meet all requirements, where they are met and it was looked at.
    """

    runs: tuple[int, ...]
    duration: float
    margin: float | None = None
    shortest: Durations | None = None
    setup: float = 0.0

    @property
    def is_met(self) -> bool | None:
        """Whether all requirements are met at full length; None where it is not known."""
        return None if self.margin is None else self.margin >= 1

    @property
    def needed(self) -> float:
        """How long it takes when no run is longer than it has to be."""
        return self.duration if self.shortest is None else self.shortest.total + self.setup


class Ranking:
    """Ranks sets of candidates, and adds runs where no set is enough.

    Parameters
    ----------
    told : what the candidates tell; None: not known
    durations, setup_time : how long each candidate takes, and setting it up
    forbidden : sets of candidates of which not all may be chosen
    rows, goal : what the candidates determine, and the rank to be reached
    """

    def __init__(
        self,
        told: Informed | None,
        durations: tuple[float, ...],
        setup_time: float,
        forbidden: Sequence[frozenset[int]],
        rows: RowSets,
        goal: int,
    ) -> None:
        self._told = told if told is not None and told.required else None
        self._durations = durations
        self._setup_time = setup_time
        self._forbidden = forbidden
        self._rows, self._goal = rows, goal
        self._asked = np.array([value for _, value in told.required]) if told is not None else np.zeros(0)

    def ranked(self, sets: Sequence[tuple[int, ...]], progress: Progress) -> tuple[RankedSet, ...]:
        """Return the sets: first those that meet what is required, the shortest first, then by margin.

        Of very many, some are looked at, evenly spread over the durations, and the best are improved by
        exchanging one run at a time.
        """
        by_duration = sorted(sets, key=lambda runs: (self._duration(runs), runs))
        step = -(-len(by_duration) // MOST_RANKED)
        found = {}
        for k, runs in enumerate(by_duration[:: max(step, 1)], start=1):
            if k % _TOLD == 1:
                progress(f"margins: {bar(k, min(len(by_duration), MOST_RANKED))}")
            found[runs] = self._of(runs)
        if step > 1:
            known = frozenset(by_duration)
            for one in sorted(found.values(), key=_preference)[:IMPROVED]:
                better = self._exchanged(one, known)
                found[better.runs] = better
        ranked = sorted(found.values(), key=_preference)
        first = []
        for k, one in enumerate(ranked[:SHORTENED], start=1):
            progress(f"shortest durations: {bar(k, min(SHORTENED, len(ranked)))}")
            first.append(self._shortened(one))
        return (*sorted(first, key=_preference), *ranked[SHORTENED:])

    def _exchanged(self, one: RankedSet, known: frozenset[tuple[int, ...]]) -> RankedSet:
        """Return a set that no exchange of a single run makes better."""
        best = one
        for k in range(len(one.runs)):
            for other in range(len(self._durations)):
                runs = tuple(sorted((*one.runs[:k], other, *one.runs[k + 1 :])))
                if runs in known:
                    best = min(best, self._of(runs), key=_preference)
        return one if best.runs == one.runs else self._exchanged(best, known)

    def _of(self, runs: tuple[int, ...]) -> RankedSet:
        setup = self._setup_time * len(runs)
        margin = None if self._told is None else self._margin(runs)
        return RankedSet(runs, self._duration(runs), margin, setup=setup)

    def _duration(self, runs: Sequence[int]) -> float:
        return sum(self._durations[k] + self._setup_time for k in runs)

    def _margin(self, runs: Sequence[int]) -> float:
        assert self._told is not None
        after = self._told.deviation([(k, -1) for k in runs], required=True)
        margins = np.divide(self._asked, after, out=np.full_like(after, np.inf), where=after > 0)
        return float(margins.min())

    def _shortened(self, one: RankedSet) -> RankedSet:
        if self._told is None or not one.is_met:
            return one
        return replace(one, shortest=shortest(self._told, one.runs))

    def extended(self, ranked: Sequence[RankedSet], progress: Progress) -> RankedSet | None:
        """Return another plan where the best of the smallest sets is not enough, or takes longer.

        Runs are added to that set, and to nothing, until the requirements are met; each time the run that
        brings the unmet ones nearest for the time it takes; at the end, those not needed are left out.
        """
        if self._told is None:
            return None
        best = ranked[0] if ranked else None
        beginnings = [()] if best is None or best.is_met else [best.runs, ()]
        found = [self._grown(runs, progress) for runs in beginnings]
        plans = [one for one in found if one is not None]
        other = min(plans, key=lambda one: one.needed, default=None)
        if other is None or (best is not None and best.is_met and other.needed >= best.needed):
            return None
        return other

    def _grown(self, runs: tuple[int, ...], progress: Progress) -> RankedSet | None:
        """Return the runs with others added until the requirements are met, None where that does not help."""
        lacking = self._lacking(runs)
        while len(runs) < MOST_ADDED and lacking > 0:
            progress(f"runs added, until what is required is met: {len(runs) + 1}")
            options = [k for k in range(len(self._durations)) if self._may_join(k, runs)]
            left = {k: self._lacking((*runs, k)) for k in options}
            best = max(left, key=lambda k: (lacking - left[k]) / self._time(k), default=None)
            if best is None or left[best] >= lacking * (1 - 1e-9):
                return None
            runs, lacking = (*runs, best), left[best]
        if lacking > 0 or not runs:
            return None
        return self._shortened(self._of(self._pruned(self._completed(runs))))

    def _completed(self, runs: tuple[int, ...]) -> tuple[int, ...]:
        """Return the runs with others added until they determine as much as can be."""
        while self._rows.rank(runs) < self._goal:
            rank = self._rows.rank(runs)
            options = [k for k in range(len(self._durations)) if self._may_join(k, runs)]
            best = max(options, key=lambda k: (self._rows.rank((*runs, k)) - rank) / self._time(k))
            if self._rows.rank((*runs, best)) == rank:
                break
            runs = (*runs, best)
        return runs

    def _lacking(self, runs: Sequence[int]) -> float:
        """Return how far the unmet requirements are from being met: the sum of ln(reached/required)."""
        assert self._told is not None
        after = self._told.deviation([(k, -1) for k in runs], required=True)
        asked = self._asked
        ratio = np.divide(after, asked, out=np.where(after > asked, _HOPELESS, 1.0), where=asked > 0)
        return float(np.log(np.clip(ratio, 1.0, _HOPELESS)).sum())

    def _time(self, k: int) -> float:
        return self._durations[k] + self._setup_time

    def _pruned(self, runs: tuple[int, ...]) -> tuple[int, ...]:
        """Return the runs without those that neither the requirements nor the rank need."""
        for k in range(len(runs) - 1, -1, -1):
            rest = (*runs[:k], *runs[k + 1 :])
            if rest and self._rows.rank(rest) == self._goal and self._margin(rest) >= 1:
                return self._pruned(rest)
        return runs

    def _may_join(self, k: int, runs: Sequence[int]) -> bool:
        return not any(one <= {*runs, k} for one in self._forbidden)


def _preference(one: RankedSet) -> tuple[object, ...]:
    if one.margin is None:
        return (0, one.duration, one.runs)
    return (0, one.needed, -one.margin, one.runs) if one.is_met else (1, -one.margin, one.duration, one.runs)
