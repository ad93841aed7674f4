"""The covariance of the Kalman filter over segments: its square root goes from one to the next.

    P(t_j⁺) = J P(t_j) Jᵀ,    L⁺ = J L

Only the first segment's P0 counts. Samples are those of one grid from the start of the first segment on; one
at the end of a segment belongs to it, and is taken before the jump.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final, TypeAlias

import numpy as np

from obscli.numeric.kalman import Known, deviations, followed
from obscli.numeric.linear_forms import Forms
from obscli.numeric.program import Array, Flags
from obscli.numeric.progress import Progress, silent, until_interrupted
from obscli.numeric.sampled_system import SampledSystem, Timeline, timeline_of
from obscli.numeric.schedule import Schedule, schedule_of
from obscli.numeric.segment_gramian import Piece
from obscli.numeric.simulation_finding import History
from obscli.numeric.wide_rows import WideRows


#: A segment with its samples, its instants, and which of them are recorded.
_Part: TypeAlias = tuple[SampledSystem, Timeline, Flags]

#: A sample is at the end of a segment if it is as near to it, in steps.
_SAME: Final = 1e-9

#: Instants recorded in one segment at least.
_FEWEST: Final = 4


def schedules_of(pieces: Sequence[Piece], step: float | None = None) -> tuple[Schedule, ...]:
    """Return when the outputs of each segment are sampled: one grid from the start of the first on.

    Parameters
    ----------
    step : as ``schedule_of``

    Raises
    ------
    NotComputableError
        as ``schedule_of``
    """
    start, stop = pieces[0].start, pieces[-1].stop
    found = []
    for k, piece in enumerate(pieces):
        grid = schedule_of(piece.system, start, stop, step)  # a step that is assumed is that of the whole
        near = _SAME * (float(np.diff(grid.t).min()) if len(grid.t) > 1 else stop - start)
        after = grid.t > piece.start + near if k else np.ones(len(grid.t), dtype=bool)
        inside = after & (grid.t <= piece.stop + near)
        t, sampled = np.minimum(grid.t[inside], piece.stop), grid.sampled[inside]
        if not len(t):  # an instant at which nothing is sampled says nothing
            t, sampled = np.array([piece.stop]), np.zeros((1, piece.system.m), dtype=bool)
        found.append(Schedule(piece.start, piece.stop, t, sampled, grid.R, grid.assumed_step))
    return tuple(found)


def assumed_step_of(schedules: Sequence[Schedule]) -> float | None:
    """Return the time between samples that is taken in segments in which nothing says it; None: in none."""
    return next((one.assumed_step for one in schedules if one.assumed_step is not None), None)


def timelines_of(pieces: Sequence[Piece], schedules: Sequence[Schedule], recorded: int) -> Iterator[_Part]:
    """Yield every segment with its samples, its instants, and which of them are recorded.

    The start of a segment is recorded where the state has jumped; the end of every one is.

    Parameters
    ----------
    recorded : at how many instants at the most, roughly
    """
    total = pieces[-1].stop - pieces[0].start
    jumped = True
    for piece, schedule in zip(pieces, schedules, strict=True):
        sampled = SampledSystem(piece.system, schedule)
        timeline = timeline_of([sampled], schedule)
        marks = timeline.marks(max(_FEWEST, round(recorded * (piece.stop - piece.start) / total)))
        marks[0] &= jumped
        yield sampled, timeline, marks
        jumped = piece.jump is not None


@np.errstate(over="ignore", invalid="ignore")  # what is not finite is refused
def segment_history(
    pieces: Sequence[Piece],
    schedules: Sequence[Schedule],
    forms: Forms,
    recorded: int = 500,
    progress: Progress = silent,
) -> History:
    """Return the standard deviations of linear forms over all segments.

    At a jump there are two instants at the same time, before and after it.

    Parameters
    ----------
    schedules : of each segment
    recorded : at how many instants at the most, roughly
    progress : told where the filter is; an interrupt keeps what is done

    Raises
    ------
    NotComputableError
        where a state has no P0, or a segment cannot be integrated
    """
    parts = list(timelines_of(pieces, schedules, recorded))
    t = np.concatenate([timeline.t[marks] for _, timeline, marks in parts])
    rows = np.concatenate(
        [forms.at(sampled.numeric, timeline.t[marks]) for sampled, timeline, marks in parts]
    )
    prior = deviations(rows[0], parts[0][0].prior)
    known = _followed(pieces, parts, progress)
    found, complete = until_interrupted(
        (deviations(row, one.root), one.open_loop.deviations(row))
        for row, one in zip(rows, known, strict=True)
    )
    done = t[: len(found)]
    closed, opened = np.array(found).reshape(len(found), 2, len(forms.names)).swapaxes(0, 1)
    samples = sum(one.samples_until(done) for one in schedules)
    return History(forms.names, forms.kinds, done, closed, opened, prior, samples, complete)


def segment_roots(pieces: Sequence[Piece], schedules: Sequence[Schedule]) -> tuple[Array, Array, WideRows]:
    """Return L with P = L Lᵀ at the start, at the end of the last segment, and there of the open loop.

    Raises
    ------
    NotComputableError
        as ``segment_history``
    """
    parts = list(timelines_of(pieces, schedules, 0))
    *_, last = _followed(pieces, parts, silent)
    return parts[0][0].prior, last.root, last.open_loop.compressed()


def _followed(pieces: Sequence[Piece], parts: Sequence[_Part], progress: Progress) -> Iterator[Known]:
    """Yield what is known at the instants recorded of all segments."""
    prior = parts[0][0].prior
    roots = prior, WideRows.of(prior)
    for piece, part in zip(pieces, parts, strict=True):
        roots = yield from followed(*part, roots, progress)
        if piece.jump is not None:
            roots = piece.jump @ roots[0], roots[1].moved(piece.jump)
