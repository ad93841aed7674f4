"""The work of ``obscli measures --window``: local observability along the interval of every stage."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from obscli.core.number import bar
from obscli.exact.motion import motion_needs
from obscli.model.specialise import at_nominal
from obscli.model.system import Model, System
from obscli.numeric.errors import NotComputableError, UnfitRequestError
from obscli.numeric.finding import NotComputed
from obscli.numeric.horizon import Horizon, horizon_of
from obscli.numeric.local_stack import frozen_stack
from obscli.numeric.local_windows import (
    WindowSettings,
    forms_at,
    sampling_of,
    window_series,
)
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.piecewise_constant import PiecewiseConstant, Segments, piecewise_constant
from obscli.numeric.rates import rates_of
from obscli.numeric.window_measures import WindowValues, joined
from obscli.numeric.window_scaling import WindowScaling, window_scaling
from obscli.numeric.windows import MOST_WINDOWS
from obscli.pipelines.numerical import settings_of
from obscli.pipelines.reading import chosen_systems
from obscli.pipelines.reading import unknown as no_such
from obscli.pipelines.request import Changes, Progress, RequestError, WindowsRequest, silent
from obscli.pipelines.windows_gains import gains_of
from obscli.pipelines.windows_report import WindowsReport
from obscli.pipelines.windows_result import Windows, WindowsResult
from obscli.pipelines.windows_warnings import warnings_of


#: Segments taken at a time.
_PORTION = 500


def windows(
    model: Model,
    request: WindowsRequest,
    changes: Changes = Changes(),  # noqa: B008 - frozen and empty
    progress: Progress = silent,
) -> WindowsReport:
    """Find how well states and quantities are observable in every window of an interval, in every stage.

    Raises
    ------
    RequestError
        where there is no such stage, or what was asked for does not fit the system
    ModelError
        where an instant is no expression in the names of the system
    """
    if request.stack == "continuous" and not request.frozen:
        raise RequestError("--stack continuous takes A and H at the start of a window: leave out --true")
    systems = chosen_systems(model, request.stages)
    return WindowsReport(tuple(windows_of(model, one, request, progress) for one in systems), changes)


def windows_of(
    model: Model, system: System, request: WindowsRequest, progress: Progress = silent
) -> WindowsResult:
    """Find the windows of one stage; raises as ``windows``."""
    progress(system.stage or model.name)
    try:
        found: Windows | NotComputed = _found(system, request, progress)
    except UnfitRequestError as error:
        raise RequestError(f"{model.file}: {error}") from error
    except NotComputableError as error:
        found = NotComputed(str(error))
    needs = motion_needs(at_nominal(system).system(), progress) if request.advice else None
    return WindowsResult(model, system, request, found, needs)


def _found(system: System, request: WindowsRequest, progress: Progress) -> Windows:
    horizon = horizon_of(system, settings_of(system, request.numeric).wanted)
    names = (*system.state_names, *(one.name for one in system.quantities))
    shown = _shown(system, names, request.show)
    numeric = NumericSystem(system, horizon.start, horizon.stop)
    settings = WindowSettings(request.length, request.step, request.stack, request.frozen, request.weights)
    sampling = sampling_of(numeric, settings, horizon.start, horizon.stop)
    scaling = window_scaling(numeric, request.scaling, sampling.h)
    every = -(-sampling.windows // request.kept)
    series = window_series(numeric, sampling, settings, scaling)
    values = joined(list(_kept(series, sampling.windows, every, progress)))
    progress("piecewise constant segments")
    segments = _segments(numeric, horizon, request.length, scaling)
    return Windows(
        horizon=horizon,
        sampling=sampling,
        scaling=scaling,
        names=names,
        shown=shown,
        values=values,
        every=every,
        segments=segments,
        gains=gains_of(names, values),
        warnings=tuple(warnings_of(request, system, names, values, scaling, segments)),
    )


def _shown(system: System, names: tuple[str, ...], asked: tuple[str, ...]) -> tuple[int, ...]:
    """Return the places of the states and quantities asked for; a vector stands for its components."""
    vectors = {state.vector for state in system.states if state.vector}
    missing = [name for name in asked if name not in {*names, *vectors}]
    if missing:
        known = [*names, *sorted(vectors)]
        raise RequestError(no_such("--show: no state, vector or quantity", missing[0], known))
    if not asked:
        return tuple(range(len(names)))
    chosen = [state.vector in asked or state.name in asked for state in system.states]
    chosen += [one.name in asked for one in system.quantities]
    return tuple(k for k, one in enumerate(chosen) if one)


def _kept(
    series: Iterator[WindowValues], count: int, every: int, progress: Progress
) -> Iterator[WindowValues]:
    """Yield every so-manieth window."""
    done = 0
    for part in series:
        k = np.arange(done, done + len(part.t))
        yield part.at(np.flatnonzero(k % every == 0))
        done += len(part.t)
        progress(f"{bar(done, count)} windows")


def _segments(
    numeric: NumericSystem, horizon: Horizon, length: float, scaling: WindowScaling
) -> PiecewiseConstant | NotComputed:
    """Return what segments as long as a window show, one after the other."""
    count = int((horizon.stop - horizon.start) / length * (1 + 1e-9))
    if count > MOST_WINDOWS:
        return NotComputed(f"{count} segments as long as a window; {MOST_WINDOWS} at the most")
    starts = horizon.start + length * np.arange(count, dtype=float)
    h, discrete = 1.0, numeric.system.discrete
    if not discrete:
        rates = rates_of(numeric, starts[[0, count // 2, -1]])
        h = min(length, 1 / rates.dynamics) if rates.dynamics else length

    def portions() -> Iterator[Segments]:
        for first in range(0, count, _PORTION):
            t = starts[first : first + _PORTION]
            found = numeric.coefficients(t)
            stack = frozen_stack(found, numeric.moving, "continuous", numeric.n, h)
            weighed = stack if scaling.weights is None else stack.weighed(scaling.weights)
            lasting = np.full(len(t), length)
            if discrete:
                powers = np.linalg.matrix_power(found.A, int(length))
                yield Segments(t, lasting, found.A - np.eye(numeric.n), found.A_error, weighed, powers)
            else:
                yield Segments(t, lasting, found.A, found.A_error, weighed)

    try:
        forms = forms_at(numeric, starts[:1])[0]
        return piecewise_constant(portions(), numeric.moving, scaling.units, forms)
    except NotComputableError as error:
        return NotComputed(str(error))
