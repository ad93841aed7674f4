"""Which of the candidate runs to make: the smallest sets, ranked by what matters, and how long each run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from obscli.core.number import bar
from obscli.exact.finding import Analysis
from obscli.exact.row_sets import RowSets
from obscli.experiment.durations import Durations, shortest
from obscli.experiment.informed import Informed, informed
from obscli.experiment.own_symbols import OwnSymbol, told_apart
from obscli.experiment.smallest_sets import SmallestSets, smallest_sets
from obscli.experiment.stacked import Progress, Stack, proved
from obscli.experiment.suggestions import Suggestion, suggestions
from obscli.model.system import Requirement, Run, System
from obscli.numeric.errors import NotComputableError
from obscli.numeric.horizon import Wanted, horizon_of


#: Sets whose durations are shortened; runs of a plan that needs more than the smallest set.
SHORTENED: Final = 12
MOST_RUNS: Final = 60

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


@dataclass(frozen=True, eq=False)
class Plan:
    """What to choose from, what it determines at the most, and what to choose.

    Parameters
    ----------
    runs : the candidates that may be chosen, with a symbol for every value of a parameter
    own : these symbols
    shared, fresh : the states that runs share, and those that start anew
    durations, setup_time : how long each candidate takes, and setting it up
    left_out : candidates that are forbidden by themselves
    stack : the rows of all candidates
    found : the smallest sets
    ranked : the sets (the shortest, where they are very many) in the order of preference; those behind the
        first few without shortened durations
    extended : more runs, some repeated, where the smallest set does not meet what is required
    informed : information of all candidates; None where ``no_accuracy`` says why not
    suggestions, tried : kinds of runs that would determine more; what was tried
    """

    runs: tuple[Run, ...]
    own: tuple[OwnSymbol, ...]
    shared: tuple[str, ...]
    fresh: tuple[str, ...]
    durations: tuple[float, ...]
    setup_time: float
    left_out: tuple[str, ...]
    stack: Stack
    found: SmallestSets
    ranked: tuple[RankedSet, ...]
    extended: RankedSet | None
    informed: Informed | None
    no_accuracy: str
    suggestions: tuple[Suggestion, ...]
    tried: tuple[str, ...]

    @property
    def chosen(self) -> RankedSet | None:
        """The plan recommended: the first set, or the extended one where only that meets what is required."""
        return self.extended or (self.ranked[0] if self.ranked else None)


def plan(
    candidates: Sequence[Run],
    shared: tuple[str, ...],
    forbidden: Sequence[Sequence[str]],
    setup_time: float,
    requirements: Sequence[Requirement],
    base: System,
    progress: Progress,
) -> Plan:
    """Find the smallest sets of candidates and rank them.

    Parameters
    ----------
    forbidden : names of candidates of which not all may be chosen
    setup_time : what setting up a run takes, in units of time
    base : the file's system, for the values of parameters

    Raises
    ------
    NotComputableError
        where the interval of a candidate is none, a candidate is undecided, or none may be chosen
    """
    left_out = {one[0] for one in forbidden if len(set(one)) == 1}
    if all(run.name in left_out for run in candidates):
        raise NotComputableError("no candidate may be chosen: all are forbidden")
    apart, own = told_apart([run for run in candidates if run.name not in left_out])
    place = {run.name: k for k, run in enumerate(apart)}
    sets = [frozenset(map(place.__getitem__, one)) for one in forbidden if left_out.isdisjoint(one)]
    stack = _stack(apart, shared, base, progress)
    rows = RowSets(stack.system, [len(one.rows) for one in stack.runs])
    found = smallest_sets(rows, sets, progress)
    durations = tuple(_duration(run) for run in apart)
    told, no_accuracy = _informed(apart, stack, requirements, progress)
    chooser = _Chooser(told, durations, setup_time, sets, rows, found.rank)
    ranked = chooser.ranked(found.sets, progress)
    kinds: tuple[tuple[Suggestion, ...], tuple[str, ...]] = ((), ())
    if found.rank < len(shared):
        kinds = suggestions(stack.runs, shared, progress)
    return Plan(
        runs=apart,
        own=own,
        shared=shared,
        fresh=tuple(name for name in apart[0].system.state_names if name not in set(shared)),
        durations=durations,
        setup_time=setup_time,
        left_out=tuple(run.name for run in candidates if run.name in left_out),
        stack=stack,
        found=found,
        ranked=ranked,
        extended=chooser.extended(ranked, progress),
        informed=told,
        no_accuracy=no_accuracy,
        suggestions=kinds[0],
        tried=kinds[1],
    )


def _stack(runs: tuple[Run, ...], shared: tuple[str, ...], base: System, progress: Progress) -> Stack:
    def told(k: int, name: str) -> None:
        progress(f"candidates: {bar(k, len(runs))} {name}")

    stack = proved(runs, shared, told, base)
    if not isinstance(stack.finding, Analysis):
        raise NotComputableError(f"undecided: {stack.finding.reason}")
    return stack


def _duration(run: Run) -> float:
    horizon = horizon_of(run.system, Wanted())
    return horizon.stop - horizon.start


def _informed(
    runs: tuple[Run, ...], stack: Stack, requirements: Sequence[Requirement], progress: Progress
) -> tuple[Informed | None, str]:
    try:
        return informed(runs, stack.system, requirements, progress), ""
    except NotComputableError as error:
        return None, str(error)


class _Chooser:
    """Ranks sets of candidates."""

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
        while len(runs) < MOST_RUNS:
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
