"""An experiment at special values of its parameters: where its rank drops, and its rank at the file's values.

The rank of M can drop only where the rank of some run drops, or that of M itself; both searches give
candidates, and each is confirmed by analysing all runs anew with the value put in. Where a run loses rank in
the states that start anew, it may even determine more of the shared ones; the analysis anew knows.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from obscli.exact.analysis import contained
from obscli.exact.errors import UndecidedError, UndefinedError
from obscli.exact.finding import Analysis, CriticalValue, Undecided
from obscli.exact.nominal import vanishes_at_nominal
from obscli.experiment.stacked import Memo, Progress, Stack, proved
from obscli.model.expression import Expression, symbols
from obscli.model.notation import to_text
from obscli.model.specialise import Specialisation
from obscli.model.system import Covector, Run, System


@dataclass(frozen=True, slots=True, eq=False)
class Special:
    """What was found at special values.

    Parameters
    ----------
    drops : where the rank is lower, or might be (undecided, undefined)
    complete : whether nothing of codimension one is left out
    not_searched : what is left out
    """

    drops: tuple[CriticalValue, ...]
    complete: bool
    not_searched: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class AtFile:
    """M at the file's values; None with a reason where there is no telling. ``because``: as for a system."""

    stack: Stack | None
    because: tuple[str, ...] = ()
    reason: str = ""

    @property
    def rank(self) -> int | None:
        """The rank at the file's values."""
        found = self.stack and self.stack.finding
        return found.rank if isinstance(found, Analysis) else None


def search(whole: Stack, shared: Sequence[str], progress: Progress) -> Special:
    """Search the parameter values at which the experiment determines less."""
    assert isinstance(whole.finding, Analysis)
    searches = [one.finding.critical for one in whole.runs if isinstance(one.finding, Analysis)]
    searches.append(whole.finding.critical)
    known = [one for one in searches if one is not None]
    drops: list[CriticalValue] = []
    for candidate in _candidates([value for one in known for value in one.values]):
        progress(f"where the rank drops: {candidate.condition}")
        found = _tried(whole, shared, candidate)
        drops += [] if found is None else [found]
    open_ = tuple(dict.fromkeys(text for one in known for text in one.not_searched))
    complete = all(one.complete for one in known) and all(one.kind != "undecided" for one in drops)
    return Special(tuple(drops), complete, open_)


def _candidates(values: Sequence[CriticalValue]) -> list[CriticalValue]:
    """Return what may matter, once each: neither what the file excludes nor identities among functions."""
    found: dict[str, CriticalValue] = {}
    for one in values:
        if one.kind != "excluded" and not one.functions:
            found.setdefault(one.condition, one)
    return [one for one in found.values() if not any(_is_part(one, other) for other in found.values())]


def _is_part(one: CriticalValue, other: CriticalValue) -> bool:
    """Whether a condition is contained in another one: lean = pi in sin(lean) = 0."""
    mine, theirs = (
        {tuple((name, to_text(value)) for name, value in values.items()) for values in each.values}
        for each in (one, other)
    )
    return one is not other and bool(mine) and mine < theirs


def _tried(whole: Stack, shared: Sequence[str], candidate: CriticalValue) -> CriticalValue | None:
    """Return the candidate with the rank of the experiment there, None where it keeps its rank."""
    if candidate.kind != "candidate" or not candidate.values:
        return replace(candidate, rank=None, lost=())
    lowest: CriticalValue | None = None
    for values in candidate.values:
        found = _at(whole, shared, candidate, values)
        if found is not None and (lowest is None or (found.rank or 0) < (lowest.rank or 0)):
            lowest = found
    return lowest


def _at(
    whole: Stack, shared: Sequence[str], candidate: CriticalValue, values: Mapping[str, Expression]
) -> CriticalValue | None:
    assert isinstance(whole.finding, Analysis)
    try:
        there = specialised(whole, shared, values).finding
        if isinstance(there, Undecided):
            return replace(candidate, kind="undecided", rank=None, lost=(), reason=there.reason)
        if there.rank >= whole.finding.rank:
            return None
        rows = [one.coefficients for one in whole.finding.combinations]
        images = [_image(whole.system, values, row) for row in rows]
        kept = contained(there, images)
    except (UndecidedError, UndefinedError) as error:
        return replace(candidate, kind="undecided", rank=None, lost=(), reason=str(error))
    lost = tuple(row for row, image, inside in zip(rows, images, kept, strict=True) if not (inside and image))
    return replace(candidate, kind="confirmed", rank=there.rank, lost=lost)


def _image(system: System, values: Mapping[str, Expression], row: Covector) -> Covector:
    return Specialisation(system, values).covector(row)


def specialised(whole: Stack, shared: Sequence[str], values: Mapping[str, Expression]) -> Stack:
    """Return the experiment with some parameters replaced, analysed anew."""
    known: dict[int, System] = {}
    runs: list[Run] = []
    for one in whole.runs:
        system = one.run.system
        if id(system) not in known:
            here = {name: value for name, value in values.items() if name in _parameters(system)}
            known[id(system)] = (
                _with_names(Specialisation(system, here).system(), here, whole) if here else system
            )
        runs.append(replace(one.run, system=known[id(system)]))
    return proved(runs, shared)


def _with_names(system: System, values: Mapping[str, Expression], whole: Stack) -> System:
    """Return the system with the parameters that the values put in name, those of other runs too."""
    named = symbols(*values.values()) - _parameters(system)
    added = tuple(one for one in whole.system.parameters if one.name in named)
    return replace(system, parameters=(*system.parameters, *added))


def _parameters(system: System) -> frozenset[str]:
    return frozenset(one.name for one in system.parameters)


def at_file(whole: Stack, shared: Sequence[str], special: Special | None, memo: Memo | None = None) -> AtFile:
    """Return the experiment at the file's values of all parameters."""
    missing = _without_value(whole)
    if missing:
        text = f"no value for {', '.join(missing)}; give one with --set {missing[0]}=…"
        return AtFile(None, reason=text)
    there = nominal(whole, shared, memo)
    if isinstance(there.finding, Undecided):
        return AtFile(None, reason=there.finding.reason)
    assert isinstance(whole.finding, Analysis)
    if there.finding.rank == whole.finding.rank or special is None:
        return AtFile(there)
    because = tuple(
        one.condition
        for one in special.drops
        if one.zero is not None and vanishes_at_nominal(whole.system, one.zero)
    )
    return AtFile(there, because)


def nominal(whole: Stack, shared: Sequence[str], memo: Memo | None = None) -> Stack:
    """Return the experiment with all parameters replaced by their values, analysed anew."""
    memo = memo or Memo()
    runs = [replace(one.run, system=memo.nominal(one.run.system)) for one in whole.runs]
    return proved(runs, shared, memo=memo)


def _without_value(whole: Stack) -> list[str]:
    """Return the parameters in use that the file gives no value."""
    found: dict[str, None] = {}
    for one in whole.runs:
        system = one.run.system
        used = symbols(*system.A.entries.values(), *system.H.entries.values())
        found.update(dict.fromkeys(p.name for p in system.parameters if p.nominal is None and p.name in used))
    return list(found)
