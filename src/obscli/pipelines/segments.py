"""What segments show together: bounds by algebra and balls, the Gramian over all of them, and warnings.

Importing this costs no floating-point library; asking for the Gramian does.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from obscli.checks.certified_segments import BITS, certified_segments
from obscli.checks.turned_between import turned_between
from obscli.exact.finding import Analysis
from obscli.experiment.hidden_throughout import everything, hidden_there, hidden_throughout
from obscli.experiment.outputs_from_start import outputs_from_start
from obscli.model.system import Model
from obscli.pipelines.request import NumericRequest, Part, Progress, RequestError, silent
from obscli.pipelines.segments_result import SegmentEnd, SegmentsResult


if TYPE_CHECKING:
    from obscli.numeric.analysis import Numeric


def segments_result(
    model: Model, request: NumericRequest, only: Part | None = None, progress: Progress = silent
) -> SegmentsResult:
    """Return what the segments of a model show together.

    Parameters
    ----------
    request : how the Gramian is to be found: its samples, step error and scaling
    only : one part alone: analytic or numeric

    Raises
    ------
    RequestError
        where the model has no segments, or what was asked for does not fit the system
    """
    segments = model.segments
    if segments is None:
        raise RequestError(f"{model.file}: there are no `segments`")
    told: Progress = lambda step: progress(f"{model.name} · segments: {step}")  # noqa: E731
    found = SegmentsResult(model, segments, None, None, None, None, None, (), turned_between(segments), only)
    if only != "numeric":
        found = _with_bounds(found, told)
    if only == "analytic":
        return replace(found, ends=_named(found))
    return _with_gramian(found, request, told)


def _with_bounds(found: SegmentsResult, told: Progress) -> SegmentsResult:
    """Return the result with both bounds; what every state is seen in needs no upper one."""
    segments, base = found.segments, found.model.systems[0]
    certified = certified_segments(segments, found.n, told, BITS[:1])
    if certified.rank == found.n:
        return replace(found, exact=everything(segments, base), certified=certified)
    exact = hidden_throughout(segments, base, told)
    most = exact.rank if isinstance(exact, Analysis) else found.n
    if certified.rank < most:
        again = certified_segments(segments, most, told, BITS[1:])
        certified = again if again.rank >= certified.rank else certified
    outputs, there = None, None
    if certified.rank < most:
        outputs = outputs_from_start(segments, base, told)
        most = min(most, outputs.rank) if isinstance(outputs, Analysis) else most
    if certified.rank < most:
        told("combinations that segments see at the file's values")
        there = hidden_there(segments, base, told)
    return replace(found, exact=exact, outputs=outputs, there=there, certified=certified)


def _with_gramian(found: SegmentsResult, request: NumericRequest, told: Progress) -> SegmentsResult:
    """Return the result with the Gramian at the end of every segment, and between."""
    from obscli.numeric.errors import NotComputableError, UnfitRequestError  # noqa: PLC0415
    from obscli.numeric.finding import NotComputed  # noqa: PLC0415
    from obscli.numeric.segment_gramian import segment_numeric  # noqa: PLC0415
    from obscli.numeric.settings import Settings  # noqa: PLC0415
    from obscli.numeric.summary import finding_of  # noqa: PLC0415

    settings = Settings(rtol=request.rtol, scaling=request.scaling)
    try:
        numeric, pieces, last = segment_numeric(found.segments, settings, request.samples, told)
    except UnfitRequestError as error:
        raise RequestError(f"{found.model.file}: {error}") from error
    except NotComputableError as error:
        return replace(found, numeric=NotComputed(str(error)), ends=_named(found))
    starts, stops = [one.start for one in pieces], [one.stop for one in pieces]
    ends = tuple(
        _end(one, start, stop, numeric, int(k))
        for one, start, stop, k in zip(_named(found), starts, stops, last, strict=True)
    )
    return replace(found, numeric=finding_of(numeric), ends=ends)


def _named(found: SegmentsResult) -> tuple[SegmentEnd, ...]:
    """Return the ends without numbers, with what is proved of each."""
    after = found.certified.after if found.certified else ()
    proved = [*after, *([None] * (len(found.segments.parts) - len(after)))]
    return tuple(
        SegmentEnd(one.name, math.nan, math.nan, one.jump is not None, own)
        for one, own in zip(found.segments.parts, proved, strict=True)
    )


def _end(one: SegmentEnd, start: float, stop: float, numeric: Numeric, k: int) -> SegmentEnd:
    spaces = numeric.spaces
    rank = int(spaces.rank[k])
    gap = float(spaces.gap[k]) if rank else None
    return replace(one, start=start, stop=stop, rank=rank, decided=bool(spaces.decided[k]), gap=gap)
