"""The Kalman filter over the segments of a model, its covariance carried from one to the next.

Importing this costs the floating-point libraries.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from obscli.exact.finding import Analysis, Undecided
from obscli.model.system import Model, System
from obscli.numeric.errors import NotComputableError
from obscli.numeric.finding import NotComputed
from obscli.numeric.schedule import Schedule
from obscli.numeric.segment_filter import schedules_of, segment_history
from obscli.numeric.segment_gramian import pieces_of
from obscli.numeric.time_to_observability import times_to_observability
from obscli.pipelines.request import NumericRequest, Progress, SimulateRequest
from obscli.pipelines.segments import segments_result
from obscli.pipelines.segments_result import SegmentsResult
from obscli.pipelines.simulate_followed import demands_of, forms_from, linear_forms, sampling_of
from obscli.pipelines.simulate_needs import lacking
from obscli.pipelines.simulate_result import Demand, FollowedForm, SimulateResult, Simulation


def simulate_segments(model: Model, request: SimulateRequest, progress: Progress) -> SimulateResult:
    """Return the simulation of the filter over all segments, or what it lacks.

    Raises
    ------
    RequestError
        where the model has no segments
    """
    bounds = segments_result(model, NumericRequest(), "analytic", progress)
    system = replace(bounds.segments.parts[0].system, stage="segments")
    try:
        found = _simulated(bounds, system, request, progress)
    except NotComputableError as error:
        return SimulateResult(model, system, NotComputed(str(error)))
    if not len(found.history.t):
        raise KeyboardInterrupt
    return SimulateResult(model, system, found, interrupted=not found.history.complete)


def _simulated(
    bounds: SegmentsResult, system: System, request: SimulateRequest, progress: Progress
) -> Simulation:
    lack = lacking(system)
    if lack:
        raise NotComputableError(lack)
    pieces = pieces_of(bounds.segments)
    schedules = schedules_of(pieces, request.step)
    forms, unsaid = _followed_forms(bounds, system)
    history = segment_history(pieces, schedules, linear_forms(system, forms), request.recorded, progress)
    demands = demands_of(system, bounds.model.require)
    end = dict(zip(history.names, history.deviations[-1], strict=True)) if len(history.t) else {}
    whole = _whole(schedules)
    return Simulation(
        start=whole.start,
        stop=whole.stop,
        default=False,
        forms=forms,
        sampling=sampling_of(system, whole),
        assumed_step=whole.assumed_step,
        history=history,
        times=times_to_observability(history, demands, request.fraction) if len(history.t) else (),
        fraction=request.fraction,
        demands=tuple(Demand(name, limit, float(end[name])) for name, limit in demands.items() if end),
        unsaid=unsaid,
        sampled=tuple(one.name for one in system.functions),
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


def _whole(schedules: tuple[Schedule, ...]) -> Schedule:
    """Return the samples of all segments as those of one interval."""
    first, last = schedules[0], schedules[-1]
    t = np.concatenate([one.t for one in schedules])
    sampled = np.concatenate([one.sampled for one in schedules])
    return replace(first, stop=last.stop, t=t, sampled=sampled)
