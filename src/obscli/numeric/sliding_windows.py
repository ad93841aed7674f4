"""Rank, gap and kernel of the Gramian over windows [s_i, s_i + T] that slide along an interval.

All windows share the panels of the interval; many are taken in portions that fit into memory. A window with
much noise, or whose rank is left open, is looked at alone: beside an earlier window with far more information
the shared error bound may be too cautious, never too bold.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from obscli.model.system import System
from obscli.numeric.analysis import affordable_steps
from obscli.numeric.errors import UnfitRequestError
from obscli.numeric.gramian import Gramian
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import Array, Counts
from obscli.numeric.rates import Rates, rates_of
from obscli.numeric.scaling import Scaling, chosen_scaling, scaled
from obscli.numeric.settings import STEP_ERROR, Effort
from obscli.numeric.sliding_root import sliding_gramians
from obscli.numeric.square_root import square_root_gramian
from obscli.numeric.subspace import Subspaces, subspaces
from obscli.numeric.transition import edges_of, longest_step
from obscli.numeric.windows import MOST_WINDOWS, joined, require_fewer


_PROBES: Final = 18

#: Windows are evenly placed if T is so near to a whole number of steps.
_WHOLE: Final = 1e-9

#: Numbers (of 8 bytes) held at a time, and how many arrays (n, n) there are for each panel.
_CHUNK: Final = 4_000_000
_HELD: Final = 10

#: Windows that share the panels before a point start so long before it that old rows grow by e^1 at the most.
_GROWN: Final = 1.0

#: Noise above so much of the largest singular value is looked at: beside a flash it may be another window's.
_CAUTIOUS: Final = 1e-11

#: A portion is at least so many times as long as a window: the panels of one are solved anew at its start.
_LEAST: Final = 4


@dataclass(frozen=True, slots=True, eq=False)
class Windows:
    """Windows [s_i, t_i] in order: ``starts``, ``stops``, neither ever decreasing, shape (N,)."""

    starts: Array
    stops: Array


def even_windows(start: float, stop: float, length: float, step: float) -> Windows:
    """Return all windows of a length, a step apart, from the start of an interval as far as they fit.

    Raises
    ------
    UnfitRequestError
        where length or step is not positive, no window fits, or there would be too many
    """
    if not (length > 0 and step > 0 and np.isfinite(length + step)):
        raise UnfitRequestError(
            f"windows of length {length:.6g} a step of {step:.6g} apart: both must be positive numbers"
        )
    room = stop - start - length
    if room < -_WHOLE * length:
        raise UnfitRequestError(
            f"a window of {length:.6g} does not fit into the interval from {start:.6g} to {stop:.6g}: "
            "choose a shorter one or a longer interval (--from, --to)"
        )
    count = max(room, 0.0) / step * (1 + _WHOLE) + _WHOLE
    require_fewer(count, MOST_WINDOWS, "windows", "step", step)
    i = np.arange(int(count) + 1, dtype=np.float64)
    starts = start + step * i
    whole = round(length / step)
    # stops and starts that coincide must be the same number
    even = whole and abs(length / step - whole) < _WHOLE * whole
    stops = start + step * (i + whole) if even else starts + length
    return Windows(starts, stops)


def slide(
    system: System, windows: Windows, scaling: Scaling | None = None, step_error: float | None = None
) -> Iterator[Subspaces]:
    """Yield rank, gap, singular values and kernel of windows, in portions, each window at its stop t_i.

    Singular values of different windows compare in fixed units only: automatic ones are each window's own.

    Parameters
    ----------
    scaling : units in which the rank is decided; None: the file's sizes, else automatic
    step_error : relative, None: that of the square root

    Raises
    ------
    NotComputableError
        where a parameter has no value, a coefficient does not exist, steps would be too many, …
    """
    numeric = NumericSystem(system, float(windows.starts[0]), float(windows.stops[-1]))
    probes = np.linspace(windows.starts[0], windows.stops[-1], _PROBES)[1:-1]
    rates, units = rates_of(numeric, probes), chosen_scaling(system, scaling)
    effort = Effort(step_error or STEP_ERROR["square-root"], affordable_steps(numeric))
    reach = _GROWN / rates.backward if rates.backward else np.inf
    held = _HELD * numeric.n**2 * (1 + float((windows.stops - windows.starts).max()) / reach)

    def decided(found: Gramian) -> Subspaces:
        return subspaces(scaled(found, system, units))

    for part in _portions(windows, longest_step(rates), _CHUNK / held, effort.most_steps):
        edges = np.unique([part.starts, part.stops])
        edges = edges_of(float(edges[0]), edges[1:], longest_step(rates), effort.most_steps)
        spaces = decided(sliding_gramians(numeric, edges, (part.starts, part.stops), reach, effort))
        yield _reconsidered(spaces, lambda s, t: decided(_alone(numeric, s, t, rates, effort)))


def _alone(system: NumericSystem, start: float, stop: float, rates: Rates, effort: Effort) -> Gramian:
    return square_root_gramian(system, start, np.array([stop]), rates, effort)


def _reconsidered(spaces: Subspaces, at: Callable[[float, float], Subspaces]) -> Subspaces:
    """Return the subspaces, doubtful windows replaced where they show more alone; three are tried."""
    with np.errstate(divide="ignore", invalid="ignore"):
        doubt = spaces.noise[:, 0] / spaces.values[:, 0]
    suspects = np.flatnonzero(~(spaces.decided & (doubt < _CAUTIOUS)))
    if not suspects.size:
        return spaces
    starts, stops = spaces.gramian.starts, spaces.instants

    def better(some: Counts) -> dict[int, Subspaces]:
        looked = {int(i): at(float(starts[i]), float(stops[i])) for i in some}
        return {i: one for i, one in looked.items() if _shows_more(one, spaces.only(i))}

    probes = suspects[np.argsort(doubt[suspects])][[0, len(suspects) // 2, -1]]
    return joined(spaces, better(suspects)) if better(probes) else spaces


def _shows_more(alone: Subspaces, shared: Subspaces) -> bool:
    rank, before = int(alone.rank[0]), int(shared.rank[0])
    return bool(alone.decided[0]) and (rank > before or (rank == before and not shared.decided[0]))


def _portions(windows: Windows, longest: float, fitting: float, most: int) -> Iterator[Windows]:
    """Yield consecutive windows, so many that their panels fit into memory and are no more than allowed."""
    edges = np.unique([windows.starts, windows.stops])
    with np.errstate(divide="ignore"):
        count = np.concatenate([[0.0], np.maximum(np.ceil(np.diff(edges) / longest), 1).cumsum()])
    before, after = (count[np.searchsorted(edges, one)] for one in (windows.starts, windows.stops))
    held = float((after - before).max())
    portion = before // max(min(max(fitting, _LEAST * held), most - held), 1)
    for part in np.split(np.arange(len(before)), np.flatnonzero(np.diff(portion)) + 1):
        yield Windows(windows.starts[part], windows.stops[part])
