"""The Kalman filter over the segments of a model, its covariance carried from one to the next.

Importing this costs the floating-point libraries.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

from obscli.exact.finding import Analysis, Undecided
from obscli.model.system import Model, System
from obscli.numeric.errors import NotComputableError, UnfitRequestError
from obscli.numeric.finding import NotComputed
from obscli.numeric.schedule import Schedule
from obscli.numeric.segment_errors import segment_errors
from obscli.numeric.segment_filter import assumed_step_of, schedules_of, segment_history
from obscli.numeric.segment_gramian import Piece, left_open, pieces_of
from obscli.numeric.time_to_observability import times_to_observability
from obscli.pipelines.request import NumericRequest, Progress, RequestError, SimulateRequest
from obscli.pipelines.segments import segments_result
from obscli.pipelines.segments_result import SegmentsResult
from obscli.pipelines.simulate_errors import ErrorSteps, carried_out
from obscli.pipelines.simulate_followed import demands_of, forms_from, linear_forms, sampling_of
from obscli.pipelines.simulate_mean import feedback_of, initial_of
from obscli.pipelines.simulate_needs import refuse_lacking
from obscli.pipelines.simulate_result import Demand, FollowedForm, SimulateResult, Simulation
from obscli.pipelines.stage_result import SEGMENTS


def simulate_segments(model: Model, request: SimulateRequest, progress: Progress) -> SimulateResult:
    """Return the simulation of the filter over all segments, or what it lacks.

    Raises
    ------
    RequestError
        where the model has no segments, or what was asked for does not fit them
    """
    bounds = segments_result(model, NumericRequest(), "analytic", progress)
    system = replace(bounds.segments.parts[0].system, stage=SEGMENTS)
    feedback = feedback_of(system, system, request.feedback)
    try:
        for k, one in enumerate(bounds.segments.parts):
            refuse_lacking(one.system, f"segment {one.name}: " if k else "", prior=not k)
        pieces = pieces_of(bounds.segments)
        inserted = initial_of(system, request.initial, pieces[0].start, pieces[0].stop)
        schedules = schedules_of(pieces, request.step)
        found = _filtered(bounds, system, pieces, schedules, request, progress)
        forms = linear_forms(system, found.forms)
        errors = cache(lambda: segment_errors(pieces, schedules, forms, request.recorded))
        asked = ErrorSteps(system, request, inserted, errors, progress)
        found, interrupted = carried_out(replace(found, feedback=feedback), asked.steps())
    except UnfitRequestError as error:
        raise RequestError(f"{model.file}: {error}") from error
    except NotComputableError as error:
        return SimulateResult(model, system, NotComputed(str(error)))
    return SimulateResult(model, system, found, interrupted)


def _filtered(
    bounds: SegmentsResult,
    system: System,
    pieces: Sequence[Piece],
    schedules: Sequence[Schedule],
    request: SimulateRequest,
    progress: Progress,
) -> Simulation:
    """Return the covariance of the filter designed on the segments."""
    forms, unsaid = _followed_forms(bounds, system)
    history = segment_history(pieces, schedules, linear_forms(system, forms), request.recorded, progress)
    if not len(history.t):
        raise KeyboardInterrupt
    demands = demands_of(system, bounds.model.require)
    end = dict(zip(history.names, history.deviations[-1], strict=True))
    return Simulation(
        start=pieces[0].start,
        stop=pieces[-1].stop,
        default=False,
        forms=forms,
        sampling=sampling_of([(one.system, own) for one, own in zip(pieces, schedules, strict=True)]),
        assumed_step=assumed_step_of(schedules),
        history=history,
        times=times_to_observability(history, demands, request.fraction),
        fraction=request.fraction,
        demands=tuple(Demand(name, limit, float(end[name])) for name, limit in demands.items()),
        unsaid=unsaid,
        sampled=left_open(pieces),
        recorded=tuple(dict.fromkeys(name for one in pieces for name in one.system.sampled)),
    )


def _followed_forms(bounds: SegmentsResult, system: System) -> tuple[tuple[FollowedForm, ...], str]:
    """Return what is followed; combinations only where they are those of the state at any time."""
    if bounds.rank == bounds.n:
        forms, _ = forms_from(system, Undecided(system, ""))
        return tuple(replace(one, verdict="observable") for one in forms), ""
    proved: Analysis | None = bounds.proved
    if proved is not None and not bounds.is_at_start:
        return forms_from(system, proved)
    reason = "the rank of the segments is not proved" if proved is None else "it is proved of the start only"
    return forms_from(system, Undecided(system, reason))
