"""The work of ``obscli analyze``: a model's systems analysed exactly and numerically, and the report."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from obscli.checks.detectability import exact_detectability, is_followable
from obscli.core.document import Document
from obscli.core.figure import Figure
from obscli.exact import analysis as engine
from obscli.exact.errors import UndecidedError, UndefinedError
from obscli.exact.finding import Analysis, Undecided
from obscli.exact.lift_finding import Stationary
from obscli.exact.stationary import find_stationary
from obscli.model.covector import parse_covectors_file
from obscli.model.discrete import require_continuous
from obscli.model.dual import is_constant
from obscli.model.specialise import at_nominal
from obscli.model.system import Model, System
from obscli.pipelines.analysis_data import report_data
from obscli.pipelines.describe.figures import analysis_figures
from obscli.pipelines.describe.report import report_document
from obscli.pipelines.describe.segments import segments_blocks
from obscli.pipelines.freezing import beside_truth, frozen_model
from obscli.pipelines.neglect import compared
from obscli.pipelines.other_stages import with_other_stages
from obscli.pipelines.reading import chosen_systems, dual_model, expanded_states
from obscli.pipelines.request import AnalyzeRequest, Changes, Progress, RequestError, silent
from obscli.pipelines.segments import segments_result
from obscli.pipelines.segments_data import segments_data
from obscli.pipelines.segments_result import SegmentsResult
from obscli.pipelines.stage_result import StageResult


@dataclass(frozen=True, slots=True, eq=False)
class AnalyzeReport:
    """What was found for each stage of one model, and the changes under which it was read."""

    results: tuple[StageResult, ...]
    changes: Changes
    segments: SegmentsResult | None = None

    @property
    def failed(self) -> int:
        """How many stages (or segments together) a Gramian or a stationary system contradicts."""
        together = self.segments is not None and self.segments.is_contradicted
        return sum(result.is_contradicted for result in self.results) + together

    @property
    def undecided(self) -> int:
        """How many stages (or segments together) stayed undecided, wholly or in part."""
        together = self.segments is not None and self.segments.is_undecided
        return sum(result.is_undecided for result in self.results) + together

    def document(self) -> Document:
        """Return the report for a reader."""
        stages = report_document(self.results)
        return Document((*stages.blocks, *segments_blocks(self.segments)))

    def figures(self) -> Iterable[Figure]:
        """Return the figures: χ, singular values, coefficients."""
        return analysis_figures(self.results)

    def data(self) -> Mapping[str, object]:
        """Return the report for a program."""
        return {**report_data(self.results, self.changes), **segments_data(self.segments)}


def analyze(
    model: Model,
    request: AnalyzeRequest = AnalyzeRequest(),  # noqa: B008 - frozen and empty
    changes: Changes = Changes(),  # noqa: B008 - frozen and empty
    unfixed: Model | None = None,
    progress: Progress = silent,
) -> AnalyzeReport:
    """Analyse the chosen stages of a model, and its segments together.

    Parameters
    ----------
    model : the model as it is to be analysed, all changes made
    request : what to analyse and how
    changes : the changes made, for the record
    unfixed : the same model without its ``fix``; where given, the report says what the fix changes
    progress : told what is being done
    """
    if request.certify and request.only == "numeric":
        raise RequestError("--certify rests on the exact kernel; leave out --only numeric")
    segments = _segments(model, request, progress)
    if request.segments:
        return AnalyzeReport((), changes, segments)
    if request.dual:
        _require_fit_for_dual(request)
        model = dual_model(model, request.stages)
        unfixed = unfixed and dual_model(unfixed, request.stages)
    for system in chosen_systems(model, request.stages):
        _require_fit_for_steps(system, request)
    true = {one.stage: one for one in model.systems}
    if request.frozen_at is not None:
        model = frozen_model(model, request.stages, request.frozen_at)
        unfixed = unfixed and frozen_model(unfixed, request.stages, request.frozen_at)
    results = []
    for system in chosen_systems(model, request.stages):
        told = _labelled(progress, f"{system.stage or model.name}: ")
        finding = None
        if request.only != "numeric":
            finding = _analyze_system(system, request, told)
            if unfixed is not None and isinstance(finding, Analysis):
                told("the system before --fix")
                finding = _with_neglect(finding, unfixed, changes)
        result = StageResult(model, system, finding, shown=request.only)
        if request.frozen_at is not None:
            told("the system in truth")
            frozen = beside_truth(true[system.stage], finding, system, request.frozen_at)
            result = replace(result, frozen=frozen)
        result = _with_detectability(result, request, told)
        if request.only not in {"analytic", "structure"}:
            result = _with_stationary(_with_gramian(result, request, told), told)
        results.append(_with_certified(result, request, told))
    return AnalyzeReport(with_other_stages(tuple(results)), changes, segments)


def _segments(model: Model, request: AnalyzeRequest, progress: Progress) -> SegmentsResult | None:
    """Return what the segments show together; None where there are none, or stages alone are asked for."""
    numeric = request.numeric
    timed = numeric.start is not None or numeric.stop is not None or bool(numeric.times)
    stages_alone = timed or bool(request.stages) or request.dual or request.frozen_at is not None
    if request.segments and (stages_alone or request.only == "structure"):
        raise RequestError(
            "--segments has the durations of the file and all of its stages: leave out --stage, --from, "
            "--to, --times, --dual, --frozen-at, --only structure"
        )
    if request.segments or not (model.segments is None or stages_alone or request.only == "structure"):
        return segments_result(model, numeric, request.only, progress)
    return None


def _require_fit_for_dual(request: AnalyzeRequest) -> None:
    if request.cross_check:
        raise RequestError("--cross-check follows the errors of an estimator; it has no meaning with --dual")


def _require_fit_for_steps(system: System, request: AnalyzeRequest) -> None:
    """Refuse what is of continuous time where the system is a discrete-time one."""
    if request.certify:
        require_continuous(system, "--certify", "the rank of [H; H F; …] is proved without it")
    if request.frozen_at is not None:
        require_continuous(system, "--frozen-at", "constant F and H are as they are at every step")
    if request.dual and not is_constant(system):
        require_continuous(system, "--dual with F, H or B that depend on the step")


def _with_detectability(result: StageResult, request: AnalyzeRequest, progress: Progress) -> StageResult:
    """Return the result with what becomes of unobservable errors, looked at where algebra leaves it open."""
    structure = result.finding.structure if isinstance(result.finding, Analysis) else None
    if structure is None:
        return result
    found = exact_detectability(structure)
    special = structure.at_values is not None and structure.verdict != "depends"
    there = exact_detectability(structure.at_values) if structure.at_values and special else None
    result = replace(result, detectability=found, detectability_there=there)
    return result if request.only == "analytic" else _followed(result, request, progress)


def _followed(result: StageResult, request: AnalyzeRequest, progress: Progress) -> StageResult:
    """Return the result with what floating point says of a verdict left open, and the cross-check."""
    system, there = result.system, result.detectability_there
    found = there or result.detectability
    if found is not None and is_followable(found.of):
        from obscli.pipelines.numerical import looked_at  # noqa: PLC0415 - floating point only where needed

        if there is None:
            result = replace(result, detectability=looked_at(system, found, request.numeric, progress))
        else:
            special = at_nominal(system).system()
            seen = looked_at(special, found, request.numeric, progress)
            result = replace(result, detectability_there=seen)
    if not request.cross_check:
        return result
    from obscli.pipelines.numerical import cross_checked  # noqa: PLC0415

    return replace(result, cross_check=cross_checked(system, request.numeric, progress))


def _with_gramian(result: StageResult, request: AnalyzeRequest, progress: Progress) -> StageResult:
    """Return the result with the Gramian, and with the comparison of the two sides where both are there."""
    from obscli.numeric.finding import NotComputed  # noqa: PLC0415 - floating point only where it is asked for
    from obscli.numeric.summary import finding_of  # noqa: PLC0415
    from obscli.pipelines.numerical import basis_in_time, numeric_of, verify_analysis  # noqa: PLC0415

    progress("Gramian")
    numeric = numeric_of(result.model, result.system, request.numeric, progress)
    if result.finding is not None:
        result = replace(result, verification=verify_analysis(result.finding, numeric))
    if isinstance(numeric, NotComputed):
        return replace(result, numeric=numeric)
    alone = request.only == "numeric"
    if alone or request.curves:
        progress("forms of the coefficients")
        result = replace(result, basis=basis_in_time(numeric, result.finding))
    if result.system.noise is not None and result.system.noise.signals:
        progress("what noise of the signals alone would show")
    return replace(result, numeric=finding_of(numeric, bases=alone))


def _with_stationary(result: StageResult, progress: Progress) -> StageResult:
    """Return the result with the stationary systems of one that varies, a witness beside the Gramian."""
    finding = result.finding
    if not isinstance(finding, Analysis) or not finding.varying or result.system.dual is not None:
        return result
    progress("stationary system")
    found = find_stationary(result.system)
    return replace(result, stationary=found if isinstance(found, Stationary) else None)


def _with_certified(result: StageResult, request: AnalyzeRequest, progress: Progress) -> StageResult:
    """Return the result with the rank of the Gramian proved at instants, where that was asked for."""
    if not request.certify:
        return result
    from obscli.pipelines.certifying import certified  # noqa: PLC0415 - floating point only where needed

    return replace(result, certified=certified(result.system, result.finding, request.numeric, progress))


def _labelled(progress: Progress, label: str) -> Progress:
    return lambda step: progress(label + step)


def _analyze_system(system: System, request: AnalyzeRequest, progress: Progress) -> Analysis | Undecided:
    basis = parse_covectors_file(system, request.basis) if isinstance(request.basis, Path) else request.basis
    options = engine.Options(
        basis=basis,
        pivot_order=expanded_states(system, request.pivot_order),
        critical=request.critical,
        relations=request.relations and not system.discrete,  # outputs as sums of functions of time
    )
    if system.dual is None:
        return engine.analyze(system, options, progress)
    # the dual of a system in time goes backwards, and advice and relations are about outputs
    options = replace(options, structure=is_constant(system), relations=False)
    found = engine.analyze(system, options, progress)
    return replace(found, advice=()) if isinstance(found, Analysis) else found


def _with_neglect(after: Analysis, unfixed: Model, changes: Changes) -> Analysis:
    """Return the finding with what the ``fix`` changed, where the system before it can be analysed."""
    before_system = next(one for one in unfixed.systems if one.stage == after.system.stage)
    options = engine.Options(critical=False, certificate=False, structure=False)
    before = engine.analyze(before_system, options, silent)
    if isinstance(before, Undecided):
        return _with_note(after, f"what the fix changes is undecided: {before.reason}")
    substitution = ", ".join(f"{name} = {value}" for name, value in changes.fix.items())
    try:
        return replace(after, neglect=(*after.neglect, compared(before, after, substitution)))
    except (UndecidedError, UndefinedError) as error:
        return _with_note(after, f"what the fix changes is undecided: {error}")


def _with_note(finding: Analysis, note: str) -> Analysis:
    return replace(finding, notes=(*finding.notes, note))
