"""The covariance of the Kalman filter over segments: its square root goes from one to the next.

    P(t_j⁺) = J P(t_j) Jᵀ,    L⁺ = J L

Only the first segment's P0 counts. Samples are those of one grid from the start of the first segment on; one
at the end of a segment belongs to it, and is taken before the jump.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from obscli.numeric.kalman import deviations, followed
from obscli.numeric.linear_forms import Forms
from obscli.numeric.program import Array
from obscli.numeric.progress import Progress, silent
from obscli.numeric.sampled_system import SampledSystem, timeline_of
from obscli.numeric.schedule import Schedule, schedule_of
from obscli.numeric.segment_gramian import Piece
from obscli.numeric.simulation_finding import History
from obscli.numeric.square_root_filter import compressed


#: Instants recorded in one segment at least.
_FEWEST = 4


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
    whole = schedule_of(pieces[0].system, start, stop, step)
    taken = step if whole.assumed_step is None else whole.assumed_step
    found = []
    for k, piece in enumerate(pieces):
        grid = schedule_of(piece.system, start, stop, taken)
        inside = (grid.t > piece.start if k else grid.t >= piece.start) & (grid.t <= piece.stop)
        t, sampled = grid.t[inside], grid.sampled[inside]
        if not len(t):  # an instant at which nothing is sampled says nothing
            t, sampled = np.array([piece.stop]), np.zeros((1, piece.system.m), dtype=bool)
        found.append(Schedule(piece.start, piece.stop, t, sampled, grid.R, whole.assumed_step))
    return tuple(found)


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
    total = pieces[-1].stop - pieces[0].start
    found: list[tuple[float, Array, Array]] = []
    roots: tuple[Array, Array] | None = None
    prior: Array | None = None
    samples, complete, jumped = 0, True, True
    try:
        for piece, schedule in zip(pieces, schedules, strict=True):
            sampled = SampledSystem(piece.system, schedule)
            timeline = timeline_of([sampled], schedule)
            marks = timeline.marks(max(_FEWEST, round(recorded * (piece.stop - piece.start) / total)))
            marks[0] &= jumped
            at = np.flatnonzero(marks)
            rows = dict(zip(at.tolist(), forms.at(sampled.numeric, timeline.t[at]), strict=True))
            if roots is None:
                roots = (sampled.prior, sampled.prior)
                prior = deviations(forms.at(sampled.numeric, timeline.t[:1])[0], sampled.prior)
            for known in followed(sampled, timeline, marks, roots, progress):
                row = rows[known.index]
                t = float(timeline.t[known.index])
                found.append((t, deviations(row, known.root), deviations(row, known.open_loop)))
                roots = (known.root, known.open_loop)
            roots = (roots[0], compressed([roots[1]]))
            samples += schedule.samples
            jumped = piece.jump is not None
            if piece.jump is not None:
                roots = (piece.jump @ roots[0], piece.jump @ roots[1])
    except KeyboardInterrupt:
        complete = False
    k, r = len(found), len(forms.names)
    times = np.array([one[0] for one in found])
    closed = np.array([one[1] for one in found]).reshape(k, r)
    opened = np.array([one[2] for one in found]).reshape(k, r)
    before = np.full(r, np.nan) if prior is None else prior
    return History(forms.names, forms.kinds, times, closed, opened, before, samples, complete)
