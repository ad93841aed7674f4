"""Errors of a Kalman filter over segments: they jump with the state, ε⁺ = J ε, see ``recorded_errors``."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from obscli.numeric.joint_errors import Pair
from obscli.numeric.linear_forms import Forms
from obscli.numeric.recorded_errors import Part, RecordedErrors, recorded_parts
from obscli.numeric.schedule import Schedule
from obscli.numeric.segment_filter import timelines_of
from obscli.numeric.segment_gramian import Piece


@np.errstate(over="ignore", invalid="ignore")  # what is not finite is refused
def segment_errors(
    pieces: Sequence[Piece], schedules: Sequence[Schedule], forms: Forms, recorded: int = 500
) -> RecordedErrors:
    """Return the errors of the filter designed on the segments themselves, to be recorded.

    What is fed back changes nothing for such a filter, see ``feedback``.

    Parameters
    ----------
    schedules : of each segment
    recorded : at how many instants at the most, roughly

    Raises
    ------
    NotComputableError
        where a state has no P0, or a segment cannot be integrated
    """
    parts = [
        Part(Pair(sampled, sampled), timeline, marks, piece.jump)
        for piece, (sampled, timeline, marks) in zip(
            pieces, timelines_of(pieces, schedules, recorded), strict=True
        )
    ]
    return recorded_parts(forms, parts)
