"""Measures of segments, at their end: those that are of a whole interval, not of one instant of one system.

Importing this costs the floating-point libraries.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final

import numpy as np

from obscli.measures.covariances import Covariances, shares
from obscli.measures.measure import Found, Measure
from obscli.measures.subject import Subject
from obscli.measures.taking import take
from obscli.model.specialise import at_nominal
from obscli.model.system import Model, Segments
from obscli.numeric.errors import NotComputableError, UnfitRequestError
from obscli.numeric.finding import NotComputed
from obscli.numeric.gramian import Gramian
from obscli.numeric.horizon import Horizon
from obscli.numeric.linear_forms import Forms
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.scaling import sizes_of
from obscli.numeric.schedule import Schedule
from obscli.numeric.segment_filter import assumed_step_of, schedules_of, segment_history, segment_roots
from obscli.numeric.segment_gramian import Piece, left_open, pieces_of, segment_numeric
from obscli.numeric.settings import Settings
from obscli.pipelines.measure_targets import targets_of
from obscli.pipelines.measures_result import Curves, MeasuresResult, Taken
from obscli.pipelines.request import MeasuresRequest, NumericRequest, Progress, RequestError
from obscli.pipelines.segments import segments_result
from obscli.pipelines.stage_result import SEGMENTS


#: The measures that a whole interval has, whatever goes on in it.
OF_INTERVALS: Final = (
    "gramian-singular-values",
    "standard-deviation",
    "stochastic",
    "covariance-reduction",
    "normalised-covariance",
)
#: Those of them that figures show against time, and at how many instants.
_AGAINST_TIME: Final = ("stochastic", "standard-deviation")
_CURVE: Final = 200
_REASON: Final = "it is one of the system in force at an instant: measure the stage (--stage)"


@dataclass(frozen=True, eq=False)
class SegmentSubject(Subject):
    """Segments to be measured at their end: what goes before it, exactly and in numbers."""

    segments: Segments | None = field(default=None, kw_only=True)
    pieces: tuple[Piece, ...] = field(default=(), kw_only=True)

    @cached_property
    def schedules(self) -> tuple[Schedule, ...]:
        """When the outputs are sampled; raises ``NotComputableError`` where the file gives no noise."""
        return schedules_of(self.pieces, self.step)

    @cached_property
    def covariances(self) -> Covariances:
        """Deviations at the end; raises ``NotComputableError`` where the file does not give the noise."""
        first, root, opened = segment_roots(self.pieces, self.schedules)
        forms = self.forms(self.at)
        prior, after = (np.linalg.norm(forms @ one, axis=1) for one in (first, root))
        return Covariances(prior, after[None], opened.deviations(forms)[None], first, root)

    @cached_property
    def gramian(self) -> Gramian:
        """The Gramian over all segments; raises ``NotComputableError`` where it cannot be found."""
        assert self.segments is not None
        found = segment_numeric(self.segments, Settings(scaling="none"), 1)[0]
        last = found.spaces.only(len(found.horizon.instants) - 1)
        return last.gramian


def measure_segments(
    model: Model,
    request: MeasuresRequest,
    chosen: Sequence[Measure],
    options: Mapping[str, Mapping[str, float | str]],
    progress: Progress,
) -> MeasuresResult:
    """Return the measures of the segments of a model at their end; others say why they are not there.

    Raises
    ------
    RequestError
        where there are no segments, or what was asked for does not fit them
    """
    if request.stages or request.at or request.numeric != NumericRequest():
        raise RequestError(
            "--segments are measured at the end of the last one: leave out --stage, --at, --times, --from, "
            "--to"
        )
    bounds = segments_result(model, NumericRequest(), "analytic", progress)
    system = replace(bounds.segments.parts[0].system, stage=SEGMENTS)
    result = MeasuresResult(model, system, tuple(chosen), NotComputed(""), request.scaling, {})
    analysis = bounds.proved
    if analysis is None or bounds.is_at_start:
        what = "is not proved" if analysis is None else "is proved of the state at the start only"
        return replace(result, taken=NotComputed(f"the rank of the segments {what}"))
    try:
        pieces = pieces_of(bounds.segments)
        units = sizes_of(system, request.scaling)
    except UnfitRequestError as error:
        raise RequestError(f"{model.file}: {error}") from error
    except NotComputableError as error:
        return replace(result, taken=NotComputed(str(error)))
    start, stop = pieces[0].start, pieces[-1].stop
    subject = SegmentSubject(
        system,
        at_nominal(system).system(),
        analysis,
        NumericSystem(pieces[-1].system, start, stop),
        start,
        stop,
        stop,
        units,
        targets_of(system, analysis, analysis),
        options,
        request.step,
        segments=bounds.segments,
        pieces=pieces,
    )
    found: dict[str, Found | NotComputed] = {one.key: NotComputed(_REASON) for one in chosen}
    found |= take(subject, [one for one in chosen if one.key in OF_INTERVALS], progress)
    return replace(
        result,
        taken=(Taken(subject, found),),
        units=dict(zip(system.state_names, map(float, units), strict=True)),
        horizon=Horizon(start, np.array([stop]), "given"),
        curves=_curves(subject, found, progress) if request.curves else None,
        assumed_step=assumed_step_of(subject.schedules) if _is_noisy(found) else None,
        sampled=left_open(pieces),
    )


def _is_noisy(found: Mapping[str, Found | NotComputed]) -> bool:
    return any(isinstance(found.get(key), Found) for key in (*_AGAINST_TIME, "covariance-reduction"))


def _curves(
    subject: SegmentSubject, found: Mapping[str, Found | NotComputed], progress: Progress
) -> Curves | None:
    """Return the measures from the noise against time; None where there are none."""
    wanted = [key for key in _AGAINST_TIME if isinstance(found.get(key), Found)]
    if not wanted:
        return None
    progress("measures against time")
    targets = subject.targets
    forms = Forms(
        tuple(one.name for one in targets),
        tuple(one.kind for one in targets),
        tuple(one.coefficients for one in targets),
    )
    history = segment_history(subject.pieces, subject.schedules, forms, _CURVE)
    known = replace(subject.covariances, after=history.deviations, open_loop=history.open_loop)
    values = {"stochastic": shares(known), "standard-deviation": known.after}
    values = {key: values[key] for key in wanted}
    return Curves(history.t, {**values, "open-loop": known.open_loop})
