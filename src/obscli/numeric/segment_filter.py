"""The covariance of the Kalman filter over segments: its square root goes from one to the next.

    P(t_j⁺) = J P(t_j) Jᵀ,    L⁺ = J L

Only the first segment's P0 counts. Samples are those of one grid from the start of the first segment on; one
at the end of a segment belongs to it, and is taken before the jump.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from obscli.numeric.kalman import deviations, followed
from obscli.numeric.linear_forms import Forms
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import Array
from obscli.numeric.progress import Progress, silent, until_interrupted
from obscli.numeric.sampled_system import SampledSystem, timeline_of
from obscli.numeric.schedule import Schedule, schedule_of
from obscli.numeric.segment_gramian import Piece
from obscli.numeric.simulation_finding import History
from obscli.numeric.wide_rows import WideRows


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
    first = SampledSystem(pieces[0].system, schedules[0])
    prior = deviations(forms.at(first.numeric, np.array([pieces[0].start]))[0], first.prior)

    def seen(one: _Known) -> tuple[float, Array, Array]:
        row = forms.at(one.numeric, np.array([one.t]))[0]
        return one.t, deviations(row, one.root), one.open_loop.deviations(row)

    found, complete = until_interrupted(map(seen, _followed(pieces, schedules, recorded, progress)))
    k, r = len(found), len(forms.names)
    times = np.array([one[0] for one in found])
    closed = np.array([one[1] for one in found]).reshape(k, r)
    opened = np.array([one[2] for one in found]).reshape(k, r)
    samples = sum(one.samples_until(times) for one in schedules)
    return History(forms.names, forms.kinds, times, closed, opened, prior, samples, complete)


def segment_roots(pieces: Sequence[Piece], schedules: Sequence[Schedule]) -> tuple[Array, Array, WideRows]:
    """Return L with P = L Lᵀ at the start, at the end of the last segment, and there of the open loop.

    Raises
    ------
    NotComputableError
        as ``segment_history``
    """
    *_, last = _followed(pieces, schedules, 0, silent)
    return SampledSystem(pieces[0].system, schedules[0]).prior, last.root, last.open_loop.compressed()


@dataclass(frozen=True, slots=True, eq=False)
class _Known:
    """What is known at an instant of a segment: L, and that of the open loop."""

    numeric: NumericSystem
    t: float
    root: Array
    open_loop: WideRows


def _followed(
    pieces: Sequence[Piece], schedules: Sequence[Schedule], recorded: int, progress: Progress
) -> Iterator[_Known]:
    """Yield what is known at instants, the end of every segment and what is after a jump among them."""
    total = pieces[-1].stop - pieces[0].start
    roots: tuple[Array, WideRows] | None = None
    jumped = True
    for piece, schedule in zip(pieces, schedules, strict=True):
        sampled = SampledSystem(piece.system, schedule)
        roots = roots or (sampled.prior, WideRows.of(sampled.prior))
        timeline = timeline_of([sampled], schedule)
        marks = timeline.marks(max(_FEWEST, round(recorded * (piece.stop - piece.start) / total)))
        marks[0] &= jumped
        for known in followed(sampled, timeline, marks, roots, progress):
            yield _Known(sampled.numeric, float(timeline.t[known.index]), known.root, known.open_loop)
            last = (known.root, known.open_loop)
        roots = (last[0], last[1].compressed())
        jumped = piece.jump is not None
        if piece.jump is not None:
            roots = (piece.jump @ roots[0], roots[1].moved(piece.jump))
