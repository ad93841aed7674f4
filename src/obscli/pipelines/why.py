"""The work of ``obscli why``: one combination of the states explained, and what would make it observable."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TypeAlias

from obscli.core.document import Document
from obscli.core.figure import Figure
from obscli.core.place import ModelError
from obscli.exact.analysis import analyze
from obscli.exact.trials import ChangeKind, Trial, try_change
from obscli.exact.why import LIGHT, Explanation, explain
from obscli.model.covector import parse_covector
from obscli.model.expression import ONE
from obscli.model.system import Model, Quantity, System
from obscli.numeric.finding import Knowledge, NotComputed
from obscli.pipelines.describe.why import why_document
from obscli.pipelines.reading import chosen_systems, load
from obscli.pipelines.request import Changes, Progress, WhyRequest, silent
from obscli.pipelines.why_data import why_data
from obscli.pipelines.why_result import WhyResult


@dataclass(frozen=True, slots=True, eq=False)
class WhyReport:
    """What was found about one target in every stage."""

    results: tuple[WhyResult, ...]
    changes: Changes

    @property
    def failed(self) -> int:
        """Nothing is checked here."""
        return 0

    @property
    def undecided(self) -> int:
        """In how many stages the verdict stayed undecided."""
        return sum(result.is_undecided for result in self.results)

    def document(self) -> Document:
        """Return the explanation for a reader."""
        return why_document(self.results)

    def figures(self) -> Iterable[Figure]:
        """Return no figures."""
        return ()

    def data(self) -> Mapping[str, object]:
        """Return the explanation for a program."""
        return why_data(self.results, self.changes)


def why(
    model: Model,
    request: WhyRequest,
    changes: Changes = Changes(),  # noqa: B008 - frozen and empty
    progress: Progress = silent,
) -> WhyReport:
    """Explain the verdict on a state, a quantity or a combination.

    Raises
    ------
    RequestError
        where there is no such stage, or the numbers asked for do not fit the system
    ModelError
        where the target is no combination of the states
    """
    results: list[WhyResult] = []
    for system in chosen_systems(model, request.stages):
        targets = targets_of(system, request.target)
        progress(f"{system.stage or model.name}: observability matrix")
        analysis = analyze(system, LIGHT)
        for target in targets:
            progress(f"{system.stage or model.name}: {target.name}")
            finding = explain(analysis, target)
            if isinstance(finding, Explanation) and finding.verdict != "observable":
                changed = (*_unfixed(model, system, changes), *_other_stages(model, system))
                tried = (_tried(one, request, target) for one in changed)
                finding = replace(finding, trials=(*finding.trials, *(one for one in tried if one)))
            results.append(WhyResult(model, system, target, finding, _known(model, system, target, request)))
    return WhyReport(tuple(results), changes)


def targets_of(system: System, text: str) -> tuple[Quantity, ...]:
    """Return what a text names: a state or the components of a vector, a quantity, or a combination.

    Raises
    ------
    ModelError
        where it is none of these
    """
    states = [state for state in system.states if text in (state.name, state.vector)]
    if states:
        return tuple(Quantity(state.name, {state.name: ONE}, state.place) for state in states)
    quantities = tuple(one for one in system.quantities if one.name == text)
    return quantities or (parse_covector(system, text, "TARGET"),)


#: A change in words, its kind, and the system with the change made; None: it cannot be made.
_Change: TypeAlias = tuple[str, ChangeKind, System | None]


def _unfixed(model: Model, system: System, changes: Changes) -> Iterator[_Change]:
    """Yield the system without one of its fixes, those of the stage and of the command line."""
    for name in dict.fromkeys((*system.fixed, *changes.fix)):
        kept = {other: value for other, value in changes.fix.items() if other != name}
        try:
            freed = load(model.file, replace(changes, fix=kept), freed=(name,)).systems
        except ModelError:
            freed = ()
        yield f"{name} free", "fix", next((one for one in freed if one.stage == system.stage), None)


def _other_stages(model: Model, system: System) -> Iterator[_Change]:
    for other in model.systems:
        if other is not system:
            yield other.stage or "the base", "stage", other


def _tried(change: _Change, request: WhyRequest, target: Quantity) -> Trial | None:
    """Return what the target is after a change, where that helps or is not known."""
    words, kind, system = change
    if system is None:
        return Trial(words, kind, "undecided", None, proved=False)
    try:
        known = {one.name: one for one in targets_of(system, request.target)}
    except ModelError:
        return None
    found = try_change(words, kind, system, known[target.name]) if target.name in known else None
    return found if found and found.becomes in {"observable", "undecided"} else None


def _known(
    model: Model, system: System, target: Quantity, request: WhyRequest
) -> Knowledge | NotComputed | None:
    """Return how well the target is known where the file has noise; None where it has none."""
    if request.only == "analytic" or system.noise is None or system.noise.R is None:
        return None
    from obscli.pipelines.numerical import known  # noqa: PLC0415 - floating point only where it is asked for

    return known(model, system, target.coefficients, request.numeric)
