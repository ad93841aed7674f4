"""The work of ``obscli calibrate``: the experiment of a model, exactly, numerically, and how well."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from obscli.core.document import Document
from obscli.core.figure import Figure
from obscli.experiment.exact_side import exactly
from obscli.model.discrete import require_continuous
from obscli.model.runs import shared_states
from obscli.model.system import Experiment, Model, Run
from obscli.model.trouble import Problems
from obscli.pipelines.calibration_data import calibration_data
from obscli.pipelines.calibration_result import CalibrationResult, RunResult
from obscli.pipelines.describe.calibration import calibration_document
from obscli.pipelines.describe.calibration_figures import calibration_figures
from obscli.pipelines.reading import unknown
from obscli.pipelines.request import CalibrateRequest, Changes, Progress, RequestError, silent


@dataclass(frozen=True, slots=True, eq=False)
class CalibrateReport:
    """What was found of the experiment of one model, and the changes under which it was read."""

    results: tuple[CalibrationResult, ...]
    changes: Changes

    @property
    def failed(self) -> int:
        """How many things are contradicted, and requirements not met."""
        return sum(result.failed for result in self.results)

    @property
    def undecided(self) -> int:
        """How many things stayed undecided."""
        return sum(result.undecided for result in self.results)

    def document(self) -> Document:
        """Return the report for a reader."""
        return calibration_document(self.results)

    def figures(self) -> Iterable[Figure]:
        """Return the figures: what each run determines, deviations in time."""
        return calibration_figures(self.results)

    def data(self) -> Mapping[str, object]:
        """Return the report for a program."""
        return calibration_data(self.results, self.changes)


def calibrate(
    model: Model,
    request: CalibrateRequest = CalibrateRequest(),  # noqa: B008 - frozen and empty
    changes: Changes = Changes(),  # noqa: B008 - frozen and empty
    progress: Progress = silent,
) -> CalibrateReport:
    """Find what the experiment of a model determines, and how well.

    Parameters
    ----------
    model : the model as it is to be analysed, all changes made
    request : which runs, and what of them
    changes : the changes made, for the record
    progress : told what is being done

    Raises
    ------
    RequestError
        where there are no runs, or none of the name asked for
    """
    for system in model.systems:
        require_continuous(system, "obscli calibrate")
    experiment, is_default = experiment_of(model)
    runs = chosen_runs(model, experiment.runs, request.runs)
    found = exactly(runs, experiment.shared, model.systems[0], progress, critical=request.critical)
    result = CalibrationResult(
        model=model,
        experiment=experiment,
        is_default=is_default,
        exact=found,
        runs=tuple(RunResult(one.run, one) for one in found.stack.runs),
        shown=request.only,
    )
    if request.only != "analytic":
        result = with_gramians(result, request, progress)
    return CalibrateReport((result,), changes)


def experiment_of(model: Model) -> tuple[Experiment, bool]:
    """Return the experiment of the file; where it has no runs, every stage is one."""
    if model.experiment is not None and model.experiment.runs:
        return model.experiment, False
    runs = tuple(Run(one.stage or model.name, one, one.stage, one.states[0].place) for one in model.systems)
    shared = shared_states([run.system for run in runs], None, Problems())
    return Experiment("", "", runs, shared), True


def chosen_runs(model: Model, runs: tuple[Run, ...], names: tuple[str, ...]) -> tuple[Run, ...]:
    """Return the runs of the given names in their order, all where none is named."""
    known = [run.name for run in runs]
    for name in names:
        if name not in known:
            raise RequestError(unknown(f"{model.file}: no run", name, known))
    return tuple(run for run in runs if not names or run.name in names)


def with_gramians(
    result: CalibrationResult, request: CalibrateRequest, progress: Progress
) -> CalibrationResult:
    """Return the result with the Gramians of all runs, what they say of it, and the accuracy."""
    from obscli.experiment.accuracy import accuracy  # noqa: PLC0415 - floating point only where it is asked for
    from obscli.experiment.agreement import verify_together  # noqa: PLC0415
    from obscli.experiment.informed import informed  # noqa: PLC0415
    from obscli.experiment.witnessed import witnessed  # noqa: PLC0415
    from obscli.numeric.errors import NotComputableError, UnfitRequestError  # noqa: PLC0415
    from obscli.numeric.finding import NotComputed  # noqa: PLC0415
    from obscli.numeric.summary import finding_of  # noqa: PLC0415
    from obscli.pipelines.numerical import Looks, settings_of, verify_analysis  # noqa: PLC0415

    exact, model = result.exact, result.model
    look = Looks(model, request.numeric, progress)
    try:
        seen = witnessed(
            exact.runs, exact.stack.system, look.numeric, settings_of(exact.stack.system, request.numeric)
        )
    except UnfitRequestError as error:
        raise RequestError(f"{model.file}: {error}") from error
    runs = []
    for one, numeric in zip(result.runs, seen.runs, strict=True):
        assert one.rows.finding is not None
        verification = verify_analysis(one.rows.finding, numeric)
        summary = numeric if isinstance(numeric, NotComputed) else finding_of(numeric, verdicts=False)
        runs.append(replace(one, numeric=summary, verification=verification))
    result = replace(
        result,
        runs=tuple(runs),
        verification=verify_together(exact.stack, exact.at_file, seen),
        together=None if seen.together is None else finding_of(seen.together, verdicts=False),
        after=None if seen.after is None else tuple(int(rank) for rank in seen.after.spaces.rank),
    )
    if seen.together is None:
        return replace(result, no_accuracy=seen.reason)
    there = exact.at_file.stack
    if there is None:
        return replace(result, no_accuracy=exact.at_file.reason)
    try:
        told = informed(there, exact.stack.system, model.require, progress)
    except NotComputableError as error:
        return replace(result, no_accuracy=str(error))
    return replace(result, accuracy=accuracy(told))
