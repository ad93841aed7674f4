"""The covariance of the Kalman filter along an interval, as a square root.

    P(t)⁻¹ = Φ⁻ᵀ (P₀⁻¹ + W_R) Φ⁻¹    where nothing drives

Panel by panel in coordinates of its start: without driving noise the samples between two instants recorded
are taken together, with driving noise one by one. Beside it the open loop, had nothing been measured: it may
grow beyond all numbers where the filter does not, and is infinite then.

References
----------
R. E. Kalman, A New Approach to Linear Filtering and Prediction Problems (1960).
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from dataclasses import dataclass

import numpy as np

from obscli.model.system import System
from obscli.numeric.linear_forms import Forms
from obscli.numeric.program import Array, Flags
from obscli.numeric.progress import Progress, silent, until_interrupted
from obscli.numeric.sampled_system import SampledSystem, Stretch, Timeline, timeline_of
from obscli.numeric.schedule import Schedule
from obscli.numeric.simulation_finding import History
from obscli.numeric.square_root_filter import compressed, informed, measured, refuse_infinite
from obscli.numeric.wide_rows import WideRows


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """What is known after the samples at an instant: its index, Φ L (n, n), and that of the open loop."""

    index: int
    root: Array
    open_loop: WideRows


@np.errstate(over="ignore", invalid="ignore")  # what is not finite is refused
def covariance_history(
    system: System, schedule: Schedule, forms: Forms, recorded: int = 500, progress: Progress = silent
) -> History:
    """Return the standard deviations of linear forms along the interval of a schedule.

    Parameters
    ----------
    recorded : at how many instants at the most
    progress : told where the filter is; an interrupt keeps what is done

    Raises
    ------
    NotComputableError
        where a state has no P0, or the system cannot be integrated
    """
    sampled = SampledSystem(system, schedule)
    timeline = timeline_of([sampled], schedule)
    marks = timeline.marks(recorded)
    t = timeline.t[marks]
    rows = forms.at(sampled.numeric, t)
    prior = deviations(forms.at(sampled.numeric, t[:1])[0], sampled.prior)
    start = (sampled.prior, WideRows.of(sampled.prior))
    found, complete = until_interrupted(
        (deviations(row, known.root), known.open_loop.deviations(row))
        for row, known in zip(rows, followed(sampled, timeline, marks, start, progress), strict=True)
    )
    k = len(found)
    closed, opened = np.array(found).reshape(k, 2, len(forms.names)).swapaxes(0, 1)
    return History(
        forms.names, forms.kinds, t[:k], closed, opened, prior, schedule.samples_until(t[:k]), complete
    )


@np.errstate(over="ignore", invalid="ignore")  # what is not finite is refused
def roots_at(system: System, schedule: Schedule, instants: Array) -> tuple[Array, list[WideRows]]:
    """Return L with P = L Lᵀ after the samples up to each instant, (k, n, n), and those of the open loop.

    Parameters
    ----------
    instants : within the interval of the schedule, ascending, shape (k,)
    """
    sampled = SampledSystem(system, schedule)
    timeline, places = timeline_of([sampled], schedule).including(instants)
    marks = np.isin(np.arange(len(timeline.t)), places)
    prior = (sampled.prior, WideRows.of(sampled.prior))
    found = {one.index: one for one in followed(sampled, timeline, marks, prior, silent)}
    roots = np.array([found[k].root for k in places])
    return roots, [found[k].open_loop.compressed() for k in places]


def deviations(rows: Array, root: Array) -> Array:
    """Return the standard deviations of linear forms (r, n) where P = L Lᵀ, shape (r,)."""
    found: Array = np.linalg.norm(rows @ root, axis=1)
    return found


def followed(
    sampled: SampledSystem,
    timeline: Timeline,
    marks: Flags,
    roots: tuple[Array, WideRows],
    progress: Progress,
) -> Generator[Known, None, tuple[Array, WideRows]]:
    """Yield what is known at the marks; return L at the end, with measurements and without.

    Parameters
    ----------
    roots : the same at the start of the timeline
    """
    root, opened = roots
    for stretch in sampled.stretches(timeline):
        part = slice(stretch.first, stretch.first + len(stretch.rows))
        progress(timeline.progress(part.start))
        rows = sampled.whitening(timeline.sample[part]) @ stretch.rows
        taken = timeline.sample[part] >= 0
        if stretch.noise is None:
            walk = _still(root, rows, taken, marks[part])
        else:
            walk = _driven(root, stretch.noise, rows, taken, marks[part])
        for k, root in walk:  # the last one is that at the panel's end
            if marks[stretch.first + k]:
                yield _known(timeline, stretch, k, root, opened)
        end = stretch.onward
        root = end @ root
        opened = opened.moved(end)
        if stretch.noise is not None:
            opened = opened.beside(tuple(end @ stretch.noise)).compressed()
    return root, opened.compressed()


def _still(root: Array, rows: Array, taken: Flags, marks: Flags) -> Iterator[tuple[int, Array]]:
    """Yield L at the marks of a panel in which nothing drives, and at its end."""
    n = root.shape[0]
    begin = 0
    for k in np.union1d(np.flatnonzero(marks), [len(rows) - 1]):
        part = slice(begin, int(k) + 1)
        if taken[part].any():
            root = informed(root, rows[part][taken[part]].reshape(-1, n))
        begin = int(k) + 1
        yield int(k), root


def _driven(
    root: Array, noise: Array, rows: Array, taken: Flags, marks: Flags
) -> Iterator[tuple[int, Array]]:
    """Yield L at the marks of a panel in which noise drives, and at its end."""
    for k, entered in enumerate(noise):
        root = measured(root, rows[k], entered)[0] if taken[k] else compressed([root, entered])
        if marks[k] or k == len(rows) - 1:
            yield k, root


def _known(timeline: Timeline, stretch: Stretch, k: int, root: Array, opened: WideRows) -> Known:
    phi = stretch.transition[k]
    open_loop = opened.moved(phi)
    if stretch.noise is not None:
        open_loop = open_loop.beside(tuple(phi @ stretch.noise[: k + 1]))
    known = Known(stretch.first + k, phi @ root, open_loop)
    refuse_infinite(timeline.t[known.index], known.root)
    return known
