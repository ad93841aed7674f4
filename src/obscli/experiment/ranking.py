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

#: Sets whose margins are looked at; of more, the shortest. So often it is told.
MOST_RANKED: Final = 4000
_TOLD: Final = 100


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
        """Return the sets: first those that meet what is required, the shortest first, then by margin."""
        by_duration = sorted(sets, key=lambda runs: (self._duration(runs), runs))[:MOST_RANKED]
        found = []
        for k, runs in enumerate(by_duration, start=1):
            if k % _TOLD == 1:
                progress(f"margins: {bar(k, len(by_duration))}")
            found.append(self._of(runs))
        found.sort(key=_preference)
        first = []
        for k, one in enumerate(found[:SHORTENED], start=1):
            progress(f"shortest durations: {bar(k, min(SHORTENED, len(found)))}")
            first.append(self._shortened(one))
        return (*sorted(first, key=_preference), *found[SHORTENED:])

    def _of(self, runs: tuple[int, ...]) -> RankedSet:
        setup = self._setup_time * len(runs)
        margin = None if self._told is None else self._margin(runs)
        return RankedSet(runs, self._duration(runs), margin, setup=setup)

    def _duration(self, runs: Sequence[int]) -> float:
        return sum(self._durations[k] + self._setup_time for k in runs)

    def _margin(self, runs: Sequence[int]) -> float:
        assert self._told is not None
        roots = [self._told.runs[k].roots[-1] for k in runs]
        after = self._told.deviation(roots, required=True)
        with np.errstate(divide="ignore"):
            return float((self._asked / after).min())

    def _shortened(self, one: RankedSet) -> RankedSet:
        if self._told is None or not one.is_met:
            return one
        return replace(one, shortest=shortest(self._told, one.runs))

    def extended(self, ranked: Sequence[RankedSet], progress: Progress) -> RankedSet | None:
        """Return the best set with runs added until the requirements are met; None where it is not needed.

        Each time the run is added that gains most for the time it takes; at the end, runs that are not needed
        any more are left out.
        """
        if self._told is None or not ranked or ranked[0].is_met or not ranked[0].margin:
            return None
        runs = ranked[0].runs
        while len(runs) < MOST_ADDED:
            progress(f"more runs, until what is required is met: {len(runs) + 1}")
            options = [k for k in range(len(self._durations)) if self._may_join(k, runs)]
            before = self._margin(runs)
            best = max(options, key=lambda k: self._gain(before, (*runs, k), k))
            runs = (*runs, best)
            margin = self._margin(runs)
            if margin >= 1:
                return self._shortened(self._of(self._pruned(runs)))
            if margin <= before * (1 + 1e-9):
                return None
        return None

    def _pruned(self, runs: tuple[int, ...]) -> tuple[int, ...]:
        """Return the runs without those that neither the requirements nor the rank need."""
        for k in range(len(runs) - 1, -1, -1):
            rest = (*runs[:k], *runs[k + 1 :])
            if rest and self._rows.rank(rest) == self._goal and self._margin(rest) >= 1:
                return self._pruned(rest)
        return runs

    def _gain(self, before: float, runs: tuple[int, ...], k: int) -> float:
        return float(np.log(self._margin(runs) / before)) / (self._durations[k] + self._setup_time)

    def _may_join(self, k: int, runs: Sequence[int]) -> bool:
        return not any(one <= {*runs, k} for one in self._forbidden)


def _preference(one: RankedSet) -> tuple[object, ...]:
    if one.margin is None:
        return (0, one.duration, one.runs)
    return (0, one.needed, -one.margin, one.runs) if one.is_met else (1, -one.margin, one.duration, one.runs)
