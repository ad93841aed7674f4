"""Which of the candidate runs to make: the smallest sets, ranked by what matters, and how long each run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from obscli.core.number import bar
from obscli.exact.finding import Analysis
from obscli.exact.row_sets import RowSets
from obscli.experiment.informed import Informed, informed
from obscli.experiment.own_symbols import OwnSymbol, told_apart
from obscli.experiment.ranking import RankedSet, Ranking
from obscli.experiment.smallest_sets import SmallestSets, smallest_sets
from obscli.experiment.special import at_file
from obscli.experiment.stacked import Progress, Stack, proved
from obscli.experiment.suggestions import Suggestion, suggestions
from obscli.model.system import Requirement, Run, System
from obscli.numeric.errors import NotComputableError
from obscli.numeric.horizon import Wanted, horizon_of


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
    not_together : sets of candidates of which not all may be chosen
    by_default : candidates whose interval the file does not give
    stack : the rows of all candidates
    there : the same at the file's values; as generic where some have none
    found : the smallest sets
    ranked : the sets (the shortest, where they are very many) in the order of preference; those behind the
        first few without shortened durations
    extended : other runs, some repeated, where the smallest set is not enough or takes longer
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
    not_together: tuple[tuple[str, ...], ...]
    by_default: tuple[str, ...]
    stack: Stack
    there: Stack
    found: SmallestSets
    ranked: tuple[RankedSet, ...]
    extended: RankedSet | None
    informed: Informed | None
    no_accuracy: str
    suggestions: tuple[Suggestion, ...]
    tried: tuple[str, ...]

    @property
    def chosen(self) -> RankedSet | None:
        """The plan recommended: the first set, or another one that is enough, or takes less time."""
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
    if not shared:
        raise NotComputableError("the candidates share no state: list what is constant under `constant`")
    apart, own = told_apart([run for run in candidates if run.name not in left_out], base)
    place = {run.name: k for k, run in enumerate(apart)}
    sets = [frozenset(map(place.__getitem__, one)) for one in forbidden if left_out.isdisjoint(one)]
    stack = _stack(apart, shared, base, progress)
    progress("candidates at the file's values")
    there = _at_values(stack, shared)
    rows = RowSets(there.system, [len(one.rows) for one in there.runs])
    found = smallest_sets(rows, sets, progress)
    horizons = [horizon_of(run.system, Wanted()) for run in apart]
    durations = tuple(one.stop - one.start for one in horizons)
    told, no_accuracy = _informed(there, stack, requirements, progress)
    ranking = Ranking(told, durations, setup_time, sets, rows, found.rank)
    ranked = ranking.ranked(found.sets, progress)
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
        not_together=tuple(tuple(apart[k].name for k in sorted(one)) for one in sets),
        by_default=tuple(
            run.name for run, one in zip(apart, horizons, strict=True) if one.origin == "default"
        ),
        stack=stack,
        there=there,
        found=found,
        ranked=ranked,
        extended=ranking.extended(ranked, progress),
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


def _at_values(stack: Stack, shared: tuple[str, ...]) -> Stack:
    """Return what the candidates determine at the file's values; as generic where these are not all given."""
    there = at_file(stack, shared, None).stack
    return there if there is not None else stack


def _informed(
    there: Stack, stack: Stack, requirements: Sequence[Requirement], progress: Progress
) -> tuple[Informed | None, str]:
    if there is stack:
        return None, "parameters without a value"
    try:
        return informed(there, stack.system, requirements, progress), ""
    except NotComputableError as error:
        return None, str(error)
