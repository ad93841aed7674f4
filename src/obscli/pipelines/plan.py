"""The work of ``obscli plan``: which of the candidate runs to make, and how long."""

from __future__ import annotations

from dataclasses import replace

from obscli.core.verification import NotVerified
from obscli.experiment.accuracy import accuracy
from obscli.experiment.agreement import verify_together
from obscli.experiment.informed import Informed, known_value
from obscli.experiment.planning import plan as choose
from obscli.experiment.ranking import RankedSet
from obscli.experiment.special import at_file
from obscli.experiment.stacked import proved
from obscli.experiment.witnessed import witnessed
from obscli.model.discrete import require_continuous
from obscli.model.system import Experiment, Model
from obscli.numeric.errors import NotComputableError
from obscli.pipelines.calibrate import chosen_runs, experiment_of
from obscli.pipelines.numerical import Looks, settings_of
from obscli.pipelines.plan_report import PlanReport
from obscli.pipelines.plan_result import PlanResult
from obscli.pipelines.plan_segments import segment_plan
from obscli.pipelines.request import Changes, PlanRequest, Progress, RequestError, silent


def plan(
    model: Model,
    request: PlanRequest = PlanRequest(),  # noqa: B008 - frozen and empty
    changes: Changes = Changes(),  # noqa: B008 - frozen and empty
    progress: Progress = silent,
) -> PlanReport:
    """Choose among the candidate runs of a model.

    Parameters
    ----------
    model : the model as it is to be analysed, all changes made
    request : which candidates
    changes : the changes made, for the record
    progress : told what is being done

    Raises
    ------
    RequestError
        where there is nothing to choose from
    """
    for system in model.systems:
        require_continuous(system, "obscli plan")
    if request.segments:
        if request.runs:
            raise RequestError("--segments chooses among the segments of the file: leave out --run")
        return PlanReport((), changes, segment_plan(model, progress))
    experiment, is_default = _to_choose_from(model)
    wanted = experiment.plan
    candidates = experiment.runs if wanted is None or wanted.candidates is None else wanted.candidates
    runs = chosen_runs(model, candidates, request.runs)
    names = {run.name for run in runs}
    forbidden = [one for one in (wanted.forbidden if wanted else ()) if names.issuperset(one)]
    base = model.systems[0]
    try:
        setup = 0.0
        if wanted is not None and wanted.setup_time is not None:
            setup = known_value(wanted.setup_time, base)
        found = choose(runs, experiment.shared, forbidden, setup, model.require, base, progress)
    except NotComputableError as error:
        raise RequestError(f"{model.file}: {error}") from error
    result = PlanResult(model, experiment, found, is_default=is_default)
    return PlanReport((_checked(result, request, progress),), changes)


def _to_choose_from(model: Model) -> tuple[Experiment, bool]:
    """Return the experiment with candidates or runs; where there is none, every stage is a candidate."""
    found = model.experiment
    if found is not None and found.plan is not None and found.plan.candidates:
        return found, False
    return experiment_of(model)


def _checked(result: PlanResult, request: PlanRequest, progress: Progress) -> PlanResult:
    """Return the plan with the accuracy it reaches, and held against the Gramians."""
    found = result.plan
    chosen = found.chosen
    if chosen is None:
        return result
    runs = [found.runs[k] for k in dict.fromkeys(chosen.runs)]
    progress("the plan against the Gramians")
    stack = proved(runs, found.shared, base=result.model.systems[0])
    look = Looks(result.model, request.numeric, progress)
    try:
        seen = witnessed(runs, stack.system, look.numeric, settings_of(stack.system, request.numeric))
        there = at_file(stack, found.shared, None)
        verification = verify_together(stack, there, seen)
        result = replace(result, rank_at_values=there.rank)
    except NotComputableError as error:
        verification = NotVerified(str(error))
    result = replace(result, chosen=stack, verification=verification)
    if found.informed is None:
        return result
    return replace(result, accuracy=accuracy(_of(found.informed, chosen)))


def _of(told: Informed, chosen: RankedSet) -> Informed:
    """Return what the chosen runs tell, each no longer than it has to be."""
    ends = None if chosen.shortest is None else chosen.shortest.durations
    runs = []
    for place, k in enumerate(chosen.runs):
        one = told.runs[k]
        count = len(one.elapsed) if ends is None else int((one.elapsed <= ends[place] * (1 + 1e-9)).sum())
        runs.append(replace(one, elapsed=one.elapsed[:count], roots=one.roots[:count]))
    return replace(told, runs=tuple(runs), kernels={})
