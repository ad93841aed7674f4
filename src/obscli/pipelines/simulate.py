"""The work of ``obscli simulate``: the Kalman filter's covariance along the interval of every stage.

Importing this costs the floating-point libraries.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cache

from obscli.model.system import Model, System
from obscli.numeric.errors import NotComputableError, UnfitRequestError
from obscli.numeric.feedback import Feedback
from obscli.numeric.finding import NotComputed
from obscli.numeric.horizon import Horizon, horizon_of
from obscli.numeric.kalman import covariance_history
from obscli.numeric.linear_forms import forms_of
from obscli.numeric.mismatched import mismatch_history
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.recorded_errors import RecordedErrors, recorded_errors
from obscli.numeric.schedule import Schedule, schedule_of
from obscli.numeric.time_to_observability import times_to_observability
from obscli.pipelines.numerical import settings_of
from obscli.pipelines.reading import chosen_systems, unknown
from obscli.pipelines.request import Changes, Progress, RequestError, SimulateRequest, silent
from obscli.pipelines.simulate_errors import ErrorSteps, Step, carried_out
from obscli.pipelines.simulate_followed import demands_of, followed_forms, linear_forms, sampling_of
from obscli.pipelines.simulate_mean import feedback_of, initial_of
from obscli.pipelines.simulate_needs import refuse_lacking
from obscli.pipelines.simulate_report import SimulateReport
from obscli.pipelines.simulate_result import Demand, FollowedForm, Mismatch, SimulateResult, Simulation
from obscli.pipelines.simulate_segments import simulate_segments


def simulate(
    model: Model,
    request: SimulateRequest = SimulateRequest(),  # noqa: B008 - frozen and empty
    changes: Changes = Changes(),  # noqa: B008 - frozen and empty
    progress: Progress = silent,
    design: Model | None = None,
) -> SimulateReport:
    """Simulate the Kalman filter of every stage of a model.

    Parameters
    ----------
    model : the model as it is to be simulated, all changes made
    request : which stages, the interval, the samples, the random runs
    changes : the changes made, for the record
    progress : told what is being done
    design : the model that the filter was designed on, where it is another

    Raises
    ------
    RequestError
        where there is no such stage, or what was asked for does not fit the system
    ModelError
        where an end of the interval is no expression in the names of the system
    """
    results: list[SimulateResult] = []
    try:
        for result in _simulated(model, request, progress, design):
            results.append(result)
            if result.interrupted:
                break
    except KeyboardInterrupt:
        if not results:
            raise
        return SimulateReport(tuple(results), changes, interrupted=True)
    return SimulateReport(tuple(results), changes, interrupted=results[-1].interrupted)


def _simulated(
    model: Model, request: SimulateRequest, progress: Progress, design: Model | None
) -> Iterator[SimulateResult]:
    """Yield the stages that are asked for, then the segments; raises as ``simulate``."""
    together = _has_segments(model, request, design)
    if not request.segments:
        systems = chosen_systems(model, request.stages)
        designs = [None if design is None else _design_of(design, system) for system in systems]
        for system, other in zip(systems, designs, strict=True):
            yield _Stage(model, system, request, progress).simulated(design, other)
    if together:
        yield simulate_segments(model, request, progress)


def _has_segments(model: Model, request: SimulateRequest, design: Model | None) -> bool:
    """Whether the segments are to be simulated, too.

    Raises
    ------
    RequestError
        where they are asked for with what only a stage can have
    """
    numeric = request.numeric
    timed = numeric.start is not None or numeric.stop is not None
    stages_alone = timed or bool(request.stages) or design is not None
    if request.segments and stages_alone:
        raise RequestError(
            "--segments has the durations of the file, all of its stages and the filter designed on them: "
            "leave out --stage, --from, --to, --filter"
        )
    if request.segments and model.segments is None:
        raise RequestError(f"{model.file}: there are no `segments`")
    return model.segments is not None and not stages_alone


def _design_of(design: Model, system: System) -> System:
    """Return the system of the filter's model for a stage of the truth: of the same name, or the only one.

    Raises
    ------
    RequestError
        where there is none
    """
    if len(design.systems) == 1:
        return design.systems[0]
    for one in design.systems:
        if one.stage == system.stage:
            return one
    stages = [one.stage for one in design.systems if one.stage is not None]
    raise RequestError(unknown(f"{design.file}: no stage for the filter", system.stage or "the base", stages))


class _Stage:
    """One stage being simulated.

    Parameters
    ----------
    model, system : the stage
    request : what is asked for
    progress : told what is being done
    """

    def __init__(self, model: Model, system: System, request: SimulateRequest, progress: Progress) -> None:
        self._model = model
        self._system = system
        self._request = request
        name = system.stage or model.name
        self._progress: Progress = lambda step: progress(f"{name}: {step}")

    def simulated(self, design: Model | None, other: System | None) -> SimulateResult:
        """Return what is found, or what is lacking; an interrupt keeps what is done."""
        system, request = self._system, self._request
        try:
            feedback = feedback_of(other or system, system, request.feedback)
            refuse_lacking(system)
            horizon = self._horizon(system)
            inserted = initial_of(system, request.initial, horizon.start, horizon.stop)
            found = replace(self._filtered(), feedback=feedback)
            errors = cache(lambda: self._errors(found.forms, feedback, other))
            asked = ErrorSteps(system, request, inserted, errors, self._progress)
            steps: list[Step] = []
            if design is not None and other is not None:
                steps = [lambda one: self._mismatched(one, design, other, errors)]
            found, interrupted = carried_out(found, [*steps, *asked.steps()])
        except UnfitRequestError as error:
            raise RequestError(f"{self._model.file}: {error}") from error
        except NotComputableError as error:
            return SimulateResult(self._model, system, NotComputed(str(error)))
        return SimulateResult(self._model, system, found, interrupted)

    def _horizon(self, system: System) -> Horizon:
        return horizon_of(system, settings_of(system, self._request.numeric).wanted)

    def _schedule(self, system: System, horizon: Horizon) -> Schedule:
        return schedule_of(system, horizon.start, horizon.stop, self._request.step)

    def _filtered(self) -> Simulation:
        """Return the covariance of the filter designed on the system itself."""
        system = self._system
        horizon = self._horizon(system)
        schedule = self._schedule(system, horizon)
        self._progress("observable combinations")
        forms, unsaid = followed_forms(system)
        history = covariance_history(
            system, schedule, linear_forms(system, forms), self._request.recorded, self._progress
        )
        if not len(history.t):
            raise KeyboardInterrupt
        demands = demands_of(system, self._model.require)
        motion = NumericSystem(system, horizon.start, horizon.stop).motion
        end = dict(zip(history.names, history.deviations[-1], strict=True))
        return Simulation(
            start=horizon.start,
            stop=horizon.stop,
            default=horizon.origin == "default",
            forms=forms,
            sampling=sampling_of([(system, schedule)]),
            assumed_step=schedule.assumed_step,
            history=history,
            times=times_to_observability(history, demands, self._request.fraction),
            fraction=self._request.fraction,
            demands=tuple(Demand(name, limit, float(end[name])) for name, limit in demands.items()),
            unsaid=unsaid,
            sampled=motion.names if motion else (),
            recorded=system.sampled,
        )

    def _mismatched(
        self, found: Simulation, design: Model, other: System, errors: Callable[[], RecordedErrors]
    ) -> Simulation:
        """Return the simulation with the true covariance of a filter designed on another system."""
        refuse_lacking(other, f"{design.file}: ")
        self._progress("the filter on the truth")
        history = mismatch_history(errors(), self._progress)
        if not len(history.t):
            raise KeyboardInterrupt
        end = dict(zip(history.names, history.true[-1], strict=True))
        demands = tuple(
            Demand(one.name, one.limit, float(end[one.name])) for one in found.demands if one.name in end
        )
        return replace(found, mismatch=Mismatch(design, other, history, demands))

    def _errors(
        self, forms: Sequence[FollowedForm], feedback: Feedback | None, other: System | None
    ) -> RecordedErrors:
        """Return the errors of the filter, of its own model or on the truth, to be recorded."""
        horizon = self._horizon(self._system)
        return recorded_errors(
            self._system,
            self._schedule(self._system, horizon),
            linear_forms(self._system, forms) if other is None else forms_of(other),
            self._request.recorded,
            filter_=other,
            filter_schedule=None if other is None else self._schedule(other, horizon),
            feedback=feedback,
        )
