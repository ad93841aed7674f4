"""The work of ``obscli why``: one combination of the states explained, and what would make it observable."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Literal

from obscli.core.document import Document
from obscli.core.figure import Figure
from obscli.core.place import ModelError
from obscli.exact.errors import UndecidedError, UndefinedError
from obscli.exact.finding import Undecided
from obscli.exact.why import Explanation, Remedy, at_values, explain, verdict_in
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
        where there is no such stage
    ModelError
        where the target is no combination of the states
    """
    results: list[WhyResult] = []
    for system in chosen_systems(model, request.stages):
        for target in targets_of(system, request.target):
            progress(f"{system.stage or model.name}: {target.name}")
            finding = explain(system, target)
            if isinstance(finding, Explanation) and finding.verdict != "observable":
                tried = (*_unfixed(model, system, target, changes), *_stages(model, system, target))
                finding = replace(finding, remedies=(*finding.remedies, *tried))
            found = WhyResult(model, system, target, finding, _known(system, target, request))
            results.append(replace(found, there=_there(finding)))
    return WhyReport(tuple(results), changes)


def _there(finding: Explanation | Undecided) -> Explanation | None:
    """Return the explanation at the file's values where the verdict is another there."""
    if isinstance(finding, Undecided) or finding.at_values is None:
        return None
    if finding.at_values.becomes == finding.verdict:
        return None
    there = explain(*at_values(finding.system, finding.target))
    return there if isinstance(there, Explanation) else None


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


def _unfixed(model: Model, system: System, target: Quantity, changes: Changes) -> Iterator[Remedy]:
    """Yield the fixes, of the stage and of the command line, that undone make the target observable."""
    for name in dict.fromkeys((*system.fixed, *changes.fix)):
        kept = {other: value for other, value in changes.fix.items() if other != name}
        try:
            freed = load(model.file, replace(changes, fix=kept), freed=(name,))
        except ModelError:
            continue  # it cannot be done without
        for other in freed.systems:
            if other.stage == system.stage:
                yield from _tried(f"{name} free", "fix", other, target)


def _stages(model: Model, system: System, target: Quantity) -> Iterator[Remedy]:
    """Yield the other stages in which the target is observable."""
    for other in model.systems:
        if other is not system:
            yield from _tried(other.stage or "the base", "stage", other, target)


def _tried(change: str, kind: Literal["fix", "stage"], system: System, target: Quantity) -> Iterator[Remedy]:
    if not set(target.coefficients) <= set(system.state_names):
        return
    try:
        verdict, rank = verdict_in(system, target)
    except (UndecidedError, UndefinedError):
        return
    if verdict == "observable":
        yield Remedy(change, kind, verdict, rank, proved=True)


def _known(system: System, target: Quantity, request: WhyRequest) -> Knowledge | NotComputed | None:
    """Return how well the target is known where the file has noise; None where it has none."""
    if request.only == "analytic" or system.noise is None or system.noise.R is None:
        return None
    from obscli.pipelines.numerical import known  # noqa: PLC0415 - floating point only where it is asked for

    return known(system, target.coefficients, request.numeric)
