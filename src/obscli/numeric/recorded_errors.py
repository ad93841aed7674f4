"""The errors of a filter along its interval, looked at where they are recorded.

The filter is designed on the truth, or on another model; see ``joint_errors`` for the errors.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from obscli.model.system import System
from obscli.numeric.feedback import Feedback
from obscli.numeric.joint_errors import Errors, Known, Pair
from obscli.numeric.linear_forms import Forms
from obscli.numeric.program import Array, Flags
from obscli.numeric.progress import Progress, until_interrupted
from obscli.numeric.sampled_system import SampledSystem, Timeline, timeline_of
from obscli.numeric.schedule import Schedule


_Seen = TypeVar("_Seen")


@dataclass(frozen=True, slots=True, eq=False)
class RecordedErrors:
    """A filter on a truth, and where its errors are recorded.

    ``t``: these instants, shape (k,); ``rows``: the forms in the filter's states there, shape (k, r, n_f).
    """

    pair: Pair
    timeline: Timeline
    marks: Flags
    t: Array
    rows: Array

    def look(
        self, errors: Errors, seen: Callable[[Known, Array], _Seen], progress: Progress
    ) -> tuple[list[_Seen], bool]:
        """Return what is seen at each instant by what is known and the rows; whether all were reached.

        Raises
        ------
        NotComputableError
            where the covariance is beyond all numbers
        """
        follow = self.pair.follow(errors, self.timeline, self.marks, progress)
        return until_interrupted(seen(known, rows) for rows, known in zip(self.rows, follow, strict=True))


def recorded_errors(
    truth: System,
    schedule: Schedule,
    forms: Forms,
    recorded: int,
    *,
    filter_: System | None = None,
    filter_schedule: Schedule | None = None,
    feedback: Feedback | None = None,
) -> RecordedErrors:
    """Return a filter designed on the truth, or on ``filter_``, and where its errors are recorded.

    Parameters
    ----------
    forms : of the filter's states
    recorded : at how many instants at the most

    Raises
    ------
    NotComputableError
        where a state has no P0, the filter takes samples that the truth does not have, or a system cannot be
        integrated
    """
    true = SampledSystem(truth, schedule)
    design = true if filter_ is None else SampledSystem(filter_, filter_schedule or schedule)
    pair = Pair(true, design, feedback)
    timeline = timeline_of([true, design], design.schedule)
    marks = timeline.marks(recorded)
    t = timeline.t[marks]
    return RecordedErrors(pair, timeline, marks, t, forms.at(design.numeric, t))
