"""The errors of a filter along its interval, looked at where they are recorded.

The filter is designed on the truth, or on another model; see ``joint_errors`` for the errors. An interval of
segments has several parts, one after the other; errors and deviations jump between them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

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
class Part:
    """A filter on a truth for some time, and where its errors are recorded; ``jump``: J at its end."""

    pair: Pair
    timeline: Timeline
    marks: Flags
    jump: Array | None = None

    @property
    def t(self) -> Array:
        """The instants recorded."""
        return self.timeline.t[self.marks]


@dataclass(frozen=True, slots=True, eq=False)
class RecordedErrors:
    """The errors of a filter, recorded.

    Parameters
    ----------
    forms : what is looked at, of the filter's states, r of them
    parts : of the interval, one after the other
    t : the instants recorded, shape (k,)
    rows : the forms there, shape (k, r, n_f)
    """

    forms: Forms
    parts: Sequence[Part]
    t: Array
    rows: Array

    @property
    def pair(self) -> Pair:
        """The truth and the filter at the start."""
        return self.parts[0].pair

    def samples_until(self, done: Array) -> int:
        """Return how many samples of single outputs the filter takes up to the last of some instants."""
        return sum(one.pair.design.schedule.samples_until(done) for one in self.parts)

    @np.errstate(over="ignore", invalid="ignore")  # what is not finite is refused
    def look(
        self, errors: Errors, seen: Callable[[Known, Array], _Seen], progress: Progress
    ) -> tuple[list[_Seen], bool]:
        """Return what is seen at each instant by what is known and the rows; whether all were reached.

        Raises
        ------
        NotComputableError
            where the covariance is beyond all numbers
        """
        known = self._followed(errors, progress)
        return until_interrupted(seen(one, rows) for rows, one in zip(self.rows, known, strict=True))

    def _followed(self, errors: Errors, progress: Progress) -> Iterator[Known]:
        root = self.pair.design.prior
        for part in self.parts:
            root = yield from part.pair.follow(errors, root, part.timeline, part.marks, progress)
            if part.jump is not None:
                root = part.jump @ root
                errors.move(part.jump)


def recorded_errors(
    truth: System,
    schedule: Schedule,
    forms: Forms,
    recorded: int = 500,
    *,
    filter_: System | None = None,
    filter_schedule: Schedule | None = None,
    feedback: Feedback | None = None,
) -> RecordedErrors:
    """Return the errors of a filter designed on the truth, or on ``filter_``, to be recorded.

    Parameters
    ----------
    forms : of the filter's states
    recorded : at how many instants at the most
    feedback : what is fed back after each sample; None: nothing, output correction

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
    return recorded_parts(forms, [Part(pair, timeline, timeline.marks(recorded))])


def recorded_parts(forms: Forms, parts: Sequence[Part]) -> RecordedErrors:
    """Return the errors over parts of an interval, to be recorded."""
    rows = [forms.at(one.pair.design.numeric, one.t) for one in parts]
    return RecordedErrors(forms, parts, np.concatenate([one.t for one in parts]), np.concatenate(rows))
