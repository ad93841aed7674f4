"""Signals: functions of time given by samples, and their derivatives, at a batch of instants at once.

On [t_i, t_{i+1}], h = t_{i+1} − t_i, u = (t − t_i)/h, Δ = y_{i+1} − y_i:

    previous    y_i
    linear      y_i + u Δ
    cubic       y_i + u (h m_i + u (3Δ − h(2 m_i + m_{i+1}) + u (h(m_i + m_{i+1}) − 2Δ)))

with the slopes m of the spline with two continuous derivatives, not-a-knot at its ends: polynomials up to the
third degree are reproduced. The samples of one file are kept as values and slopes, 16 bytes a number.

A derivative is a function as long as it exists between the samples: of order 3, 1 and 0. Relations between
observable combinations are differentiated once more, so that they hold across a sample only where the
highest derivative they name is continuous: of order 2, 0 and −1.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Final, TypeAlias

import numpy as np

from obscli.model.signal_file import Interpolation, SignalFile
from obscli.model.system import System
from obscli.numeric.errors import NotComputableError, UnfitRequestError
from obscli.numeric.program import ROUNDING, Array, Value, constant_value, jet
from obscli.numeric.signal_table import FEWEST, read_columns


#: The highest derivative that exists between the samples, and the highest that is continuous across them.
DEGREE: Final[Mapping[Interpolation, int]] = {"cubic": 3, "linear": 1, "previous": 0}
CONTINUOUS: Final[Mapping[Interpolation, int]] = {"cubic": 2, "linear": 0, "previous": -1}

#: A step so many times the median one is a gap where the file does not say.
_GAP: Final = 10.0

#: An instant beyond the samples by less than this share of their span is at their end.
_END: Final = 1e-9

#: Roundings in a polynomial of the third degree, about.
_ROUNDINGS: Final = 4.0

#: Files kept in memory, each once for all systems that use it.
_KEPT: Final = 4


@dataclass(frozen=True, slots=True)
class _Request:
    """What is read of a file, in numbers: what can be told apart by it is read once."""

    path: Path
    changed: tuple[int, int]
    time: str
    columns: tuple[str, ...]
    factors: tuple[float, ...]
    unwraps: tuple[float, ...]
    time_factor: float
    zero: float | None
    interpolation: Interpolation


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """The samples of one file.

    Parameters
    ----------
    file : its name, for messages
    names : the functions, d of them
    interpolation : how they go from sample to sample
    t : the times, ascending, shape (N,)
    values, slopes : shape (N, d); no slopes unless cubic
    """

    file: str
    names: tuple[str, ...]
    interpolation: Interpolation
    t: Array
    values: Array
    slopes: Array

    def at(self, t: Array, order: int, columns: Sequence[int]) -> Array:
        """Return derivatives of an order of some columns at instants, shape (len(columns), len(t))."""
        i = np.clip(np.searchsorted(self.t, t, side="right") - 1, 0, len(self.t) - 2)
        if self.interpolation == "previous":
            last = np.where(t >= self.t[-1], len(self.t) - 1, i)
            return self.values[last][:, columns].T if order == 0 else np.zeros((len(columns), len(t)))
        if order > DEGREE[self.interpolation]:
            return np.zeros((len(columns), len(t)))
        h = (self.t[i + 1] - self.t[i])[:, None]
        u = (t[:, None] - self.t[i][:, None]) / h
        y, rise = self.values[i][:, columns], (self.values[i + 1] - self.values[i])[:, columns]
        if self.interpolation == "linear":
            return (y + u * rise if order == 0 else rise / h).T
        left, right = h * self.slopes[i][:, columns], h * self.slopes[i + 1][:, columns]
        bend, twist = 3 * rise - 2 * left - right, left + right - 2 * rise
        match order:
            case 0:
                found = y + u * (left + u * (bend + u * twist))
            case 1:
                found = (left + u * (2 * bend + 3 * u * twist)) / h
            case 2:
                found = (2 * bend + 6 * u * twist) / h**2
            case _:
                found = 6 * twist / h**3
        return np.asarray(found.T, dtype=float)


#: Changes the samples of an entry of ``signals``, given its number.
Changed: TypeAlias = Callable[[int, Samples], Samples]


class Signals:
    """The functions of a system that files give, from start to stop; ``changed``: what is done to them first.

    Raises
    ------
    NotComputableError
        where a file is not as the model says, has a gap in the interval, or does not cover it
    """

    def __init__(self, system: System, start: float, stop: float, changed: Changed | None = None) -> None:
        self._files = samples_of(system)
        if changed is not None:
            self._files = tuple(changed(k, one) for k, one in enumerate(self._files))
        require_covered(self._files, start, stop, asked=False)
        for file, one in zip(system.signals, self._files, strict=True):
            _require_no_gap(file, one, start, stop)
        self._of = {name: (file, k) for file in self._files for k, name in enumerate(file.names)}
        self._ends = overlap(self._files)

    @property
    def names(self) -> frozenset[str]:
        """The functions."""
        return frozenset(self._of)

    @property
    def files(self) -> tuple[Samples, ...]:
        """The samples, file by file."""
        return self._files

    def values(self, t: Array, orders: Mapping[str, int]) -> dict[str, Array]:
        """Return the functions at instants, and their derivatives up to the orders asked for.

        Raises
        ------
        NotComputableError
            where a derivative does not exist
        """
        inside = np.clip(t, *self._ends)
        found: dict[str, Array] = {}
        for file in self._files:
            wanted = [min(orders.get(name, 0), 99) for name in file.names]
            top = max(wanted, default=0)
            if top > DEGREE[file.interpolation]:
                raise NotComputableError(_no_derivative(file, file.names[wanted.index(top)], top))
            for order in range(top + 1):
                columns = [k for k, most in enumerate(wanted) if most >= order]
                for k, values in zip(columns, file.at(inside, order, columns), strict=True):
                    found[jet(file.names[k], order)] = values
        return found

    def errors(self, t: Value, values: Mapping[str, Value]) -> dict[str, Value]:
        """Return the rounding errors of signals and derivatives among some values: time itself is rounded."""
        inside = np.clip(np.atleast_1d(t), *self._ends)
        found: dict[str, Value] = {}
        for file in self._files:
            order = 0
            while columns := [k for k, name in enumerate(file.names) if jet(name, order) in values]:
                rates = file.at(inside, order + 1, columns)
                for k, rate in zip(columns, rates, strict=True):
                    name = jet(file.names[k], order)
                    found[name] = _ROUNDINGS * ROUNDING * (np.abs(values[name]) + np.abs(rate * inside))
                order += 1
        return found

    def smoothness(self, name: str) -> int:
        """Return the highest order of a derivative of a signal that is continuous, −1: it jumps itself."""
        return CONTINUOUS[self._of[name][0].interpolation]

    def knots(self, start: float, stop: float) -> Array:
        """Return the times of samples between two instants, without those that rounding puts at them."""
        parts = []
        for file in self._files:
            near = _END * (file.t[-1] - file.t[0]) / len(file.t)
            first, last = np.searchsorted(file.t, [start + near, stop - near])
            parts.append(file.t[first:last])
        return np.unique(np.concatenate(parts)) if parts else np.empty(0)


def samples_of(system: System) -> tuple[Samples, ...]:
    """Return the samples of the files of a system, those columns that are functions of it.

    Raises
    ------
    NotComputableError
        where a file is not as the model says
    """
    names = {one.name for one in system.functions}
    return tuple(_samples(one, names) for one in system.signals)


def _samples(file: SignalFile, functions: set[str]) -> Samples:
    columns = [one for one in file.columns if one.name in functions]
    try:
        stat = file.file.stat()
    except OSError:
        raise NotComputableError(f"{file.file.name}: there is no such file") from None
    zero = None if file.zero == "first" else 0.0
    if not isinstance(file.zero, str):
        zero = constant_value(file.zero, {})
    request = _Request(
        path=file.file.resolve(),
        changed=(stat.st_mtime_ns, stat.st_size),
        time=file.time,
        columns=tuple(one.column for one in columns),
        factors=tuple(1.0 if one.factor is None else constant_value(one.factor, {}) for one in columns),
        unwraps=tuple(0.0 if one.unwrap is None else constant_value(one.unwrap, {}) for one in columns),
        time_factor=1.0 if file.factor is None else constant_value(file.factor, {}),
        zero=zero,
        interpolation=file.interpolation,
    )
    t, values, slopes = _loaded(request)
    return Samples(file.file.name, tuple(one.name for one in columns), file.interpolation, t, values, slopes)


@lru_cache(maxsize=_KEPT)
def _loaded(request: _Request) -> tuple[Array, Array, Array]:
    """Return times, values and slopes."""
    name = request.path.name
    found = read_columns(request.path, (request.time, *request.columns))
    if found.shape[1] < FEWEST:
        raise NotComputableError(f"{name}: {found.shape[1]} rows of samples; at least {FEWEST} are needed")
    _require_finite(name, found, (request.time, *request.columns))
    raw = found[0]
    zero = raw[0] if request.zero is None else request.zero
    t = (raw - zero) * request.time_factor
    _require_order(name, request.time, raw, t)
    values = np.empty((len(t), len(request.columns)))
    for k, (factor, turn) in enumerate(zip(request.factors, request.unwraps, strict=True)):
        column = np.unwrap(found[k + 1], period=turn) if turn else found[k + 1]
        values[:, k] = factor * column
    slopes = slopes_of(t, values) if request.interpolation == "cubic" else np.empty((0, values.shape[1]))
    for one in (t, values, slopes):
        one.setflags(write=False)
    return t, values, slopes


def slopes_of(t: Array, values: Array) -> Array:
    """Return the slopes of the not-a-knot cubic spline at the samples, column by column, shape (N, d)."""
    from scipy.interpolate import CubicSpline  # noqa: PLC0415 - half a second to import, for signals only

    slopes = np.empty_like(values)
    for k in range(values.shape[1]):
        spline = CubicSpline(t, values[:, k])
        slopes[:, k] = spline(t, 1)
    return slopes


def _require_finite(name: str, found: Array, columns: Sequence[str]) -> None:
    for column, values in zip(columns, found, strict=True):
        bad = np.flatnonzero(~np.isfinite(values))
        if bad.size:
            more = f" (and {bad.size - 1} more)" if bad.size > 1 else ""
            raise NotComputableError(
                f"{name}, row {bad[0] + 1} of the samples, column '{column}': {values[bad[0]]:g} is no value"
                f"{more}: leave out the row, or give the column a file of its own"
            )


def _require_order(name: str, column: str, raw: Array, t: Array) -> None:
    steps = np.diff(t)
    bad = np.flatnonzero(~(steps > 0))
    if not bad.size:
        return
    k = int(bad[0])
    where = f"{name}, rows {k + 1} and {k + 2} of the samples, column '{column}'"
    if raw[k] == raw[k + 1]:
        raise NotComputableError(f"{where}: the time {raw[k]:.10g} stands twice: leave out one of the rows")
    if (np.diff(raw) < 0).all() or len(bad) == len(steps):
        raise NotComputableError(f"{where}: times go backwards: sort the rows")
    raise NotComputableError(
        f"{where}: {raw[k + 1]:.10g} follows {raw[k]:.10g}: times must grow; sort the rows, or cut the file "
        "where its clock was set"
    )


def _require_no_gap(file: SignalFile, found: Samples, start: float, stop: float) -> None:
    steps = np.diff(found.t)
    median = float(np.median(steps))
    allowed = _GAP * median if file.max_gap is None else constant_value(file.max_gap, {})
    inside = (found.t[1:] > start) & (found.t[:-1] < stop)
    gaps = np.flatnonzero(inside & (steps > allowed * (1 + _END)))
    if not gaps.size:
        return
    k = int(gaps[0])
    more = f", and {gaps.size - 1} more gaps" if gaps.size > 1 else ""
    raise NotComputableError(
        f"{found.file} has no samples from {found.t[k]:.6g} to {found.t[k + 1]:.6g}, "
        f"{steps[k] / median:.3g} times the median step{more}: choose an interval without it "
        f"(--from, --to), or `max_gap: {steps[gaps].max() * 1.001:.3g}` to interpolate across it"
    )


def overlap(files: Sequence[Samples]) -> tuple[float, float]:
    """Return the interval that all files cover.

    Raises
    ------
    NotComputableError
        where there is none
    """
    first, last = max(one.t[0] for one in files), min(one.t[-1] for one in files)
    if not first < last:
        raise NotComputableError(f"the files of `signals` do not overlap in time: {_spans(files)}")
    return float(first), float(last)


def require_covered(files: Sequence[Samples], start: float, stop: float, *, asked: bool) -> None:
    """Refuse an interval that the files do not cover; ``asked``: the user asked for it."""
    first, last = overlap(files)
    room = _END * (last - first)
    if start < first - room or stop > last + room:
        raise (UnfitRequestError if asked else NotComputableError)(outside(files, start, stop))


def outside(files: Sequence[Samples], start: float, stop: float) -> str:
    """Return that an interval is not within the samples, and what is."""
    first, last = overlap(files)
    return (
        f"the interval from {start:.6g} to {stop:.6g} is not within the samples of `signals`: "
        f"{_spans(files)}{'; all' if len(files) > 1 else ''}: choose one within {first:.10g} to {last:.10g} "
        "(--from, --to, or `interval` in the file)"
    )


def _spans(files: Sequence[Samples]) -> str:
    return ", ".join(f"{one.file} from {one.t[0]:.6g} to {one.t[-1]:.6g}" for one in files)


def _no_derivative(file: Samples, name: str, order: int) -> str:
    return (
        f"the derivative of order {order} of the signal {name} does not exist with `interpolation: "
        f"{file.interpolation}` (up to order {DEGREE[file.interpolation]} it does): choose cubic, or give "
        "the derivative a column of its own"
    )
