"""Local observability along an interval: window after window, in portions that fit into memory.

Windows start a step apart, at t_i; each holds N samples, h apart, t_i + j h < t_i + T. *Frozen*: A and H keep
the values they have at t_i; *true*: they vary along the window. R is of the state at the start of the window.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from obscli.numeric.errors import UnfitRequestError
from obscli.numeric.local_stack import Form, LocalStack, frozen_stack, true_stack
from obscli.numeric.noise import steps_of
from obscli.numeric.numeric_system import Coefficients, NumericSystem
from obscli.numeric.program import EPS, Array, Counts, Flags
from obscli.numeric.sample_transitions import sample_transitions
from obscli.numeric.schedule import sampled_within
from obscli.numeric.subspace import Subspaces, subspaces
from obscli.numeric.window_measures import Weights, WindowValues, window_values
from obscli.numeric.window_scaling import WindowScaling
from obscli.numeric.windows import MOST_WINDOWS, require_fewer


#: Numbers (of 8 bytes) of one stack held at a time.
_CHUNK: Final = 1_000_000

#: Samples in a window at the most.
MOST_SAMPLES: Final = 100_000

#: A sample, or a window, still fits if it is late by so much of a step.
_FITS: Final = 1e-6


@dataclass(frozen=True, slots=True)
class WindowSettings:
    """What is asked of the windows.

    ``length``: T; ``step``: between windows, None: as between samples; ``form``: samples or derivatives;
    ``frozen``: whether A and H keep the values of the start; ``weights``: of the singular values.
    """

    length: float
    step: float | None = None
    form: Form = "discrete"
    frozen: bool = True
    weights: Weights = "squared"


@dataclass(frozen=True, slots=True, eq=False)
class Sampling:
    """Where the windows are.

    Parameters
    ----------
    start, step, windows : of the first window, between windows, and how many there are
    h, samples : between samples, and how many in a window
    """

    start: float
    step: float
    windows: int
    h: float
    samples: int

    def starts(self, first: int, last: int) -> Array:
        """Return t_i of windows first to last − 1."""
        return self.start + self.step * np.arange(first, last, dtype=float)


def sampling_of(numeric: NumericSystem, settings: WindowSettings, start: float, stop: float) -> Sampling:
    """Return the windows of an interval: samples as often as the file says, else as often as windows.

    Raises
    ------
    UnfitRequestError
        where nothing says how often, no sample fits into a window, no window into the interval, or too many
    """
    length, step = settings.length, settings.step
    for name, value in (("--window", length), ("--step", step)):
        if value is not None and not 0 < value < np.inf:
            raise UnfitRequestError(f"{name} {value:g}: a positive number is expected")
    if numeric.system.discrete and not (length.is_integer() and (step is None or step.is_integer())):
        raise UnfitRequestError("--window and --step of a discrete-time model are whole numbers of steps")
    given = [one for one in steps_of(numeric.system) if one is not None]
    h = 1.0 if numeric.system.discrete else min(given) if given else step
    if h is None:
        raise UnfitRequestError(
            "nothing says how often outputs are sampled: give --step, or `step` under `noise`"
        )
    samples = float(np.ceil(length / h - _FITS))
    if length < h * (1 - _FITS):
        raise UnfitRequestError(f"a window of {length:g} holds no two samples, which are {h:g} apart")
    room = stop - start - (samples - 1) * h
    if room < -_FITS * h:
        raise UnfitRequestError(
            f"a window of {length:g} does not fit into the interval from {start:g} to {stop:g}: "
            "choose a shorter one or a longer interval (--from, --to)"
        )
    require_fewer(samples, MOST_SAMPLES, "samples of each window", "time between samples", h)
    apart = step or h
    count = max(room, 0.0) / apart + _FITS
    require_fewer(count, MOST_WINDOWS, "windows", "step", apart)
    return Sampling(start, apart, int(count) + 1, h, int(samples))


def window_series(
    numeric: NumericSystem, sampling: Sampling, settings: WindowSettings, scaling: WindowScaling
) -> Iterator[WindowValues]:
    """Yield the values of all windows in order, in portions.

    Raises
    ------
    NotComputableError
        where a coefficient does not exist at some instant, or cannot be resolved
    """
    size = max(sampling.samples * numeric.m, numeric.n) * numeric.n
    portion = max(_CHUNK // size, 1)
    for first in range(0, sampling.windows, portion):
        t = sampling.starts(first, min(first + portion, sampling.windows))
        yield values_of(stack_at(numeric, sampling, settings, t), forms_at(numeric, t), t, settings, scaling)


def values_of(
    stack: LocalStack, forms: Array, t: Array, settings: WindowSettings, scaling: WindowScaling
) -> WindowValues:
    """Return the values of windows of which R is known: k windows, q linear forms (k, q, n)."""
    weighed = stack if scaling.weights is None else stack.weighed(scaling.weights)
    found = decomposed(weighed, t, scaling.units)
    informed = None
    if scaling.is_of_prior:
        informed = (found.gramian.matrices, np.diag(scaling.units))
    elif scaling.prior is not None and scaling.whitening is not None:
        root = stack.weighed(scaling.whitening).triangle(t, t, np.ones(len(scaling.units)))
        informed = (root.matrices @ scaling.prior, scaling.prior)
    return window_values(found, forms, settings.weights, informed)


def decomposed(stack: LocalStack, t: Array, units: Array) -> Subspaces:
    """Return R D = U Σ Vᵀ of windows that start at t."""
    return subspaces(stack.triangle(t, t, units))


def forms_at(numeric: NumericSystem, t: Array) -> Array:
    """Return the states and then the quantities as covectors at instants, shape (k, n + q, n)."""
    states = np.broadcast_to(np.eye(numeric.n), (len(t), numeric.n, numeric.n))
    quantities = numeric.system.quantities
    if not quantities:
        return states
    rows, _ = numeric.covectors([one.coefficients for one in quantities], t)
    return np.concatenate([states, rows], axis=1)


def stack_at(numeric: NumericSystem, sampling: Sampling, settings: WindowSettings, t: Array) -> LocalStack:
    """Return R of windows that start at t, in the file's units; a row that is not sampled is zero."""
    if settings.frozen and numeric.system.discrete:
        found = frozen_stack(numeric.coefficients(t), numeric.moving, "continuous", sampling.samples, 1.0)
    elif settings.frozen:
        h = 1.0 if settings.form == "continuous" else sampling.h
        count = min(sampling.samples, numeric.n) if settings.form == "continuous" else sampling.samples
        found = frozen_stack(numeric.coefficients(t), numeric.moving, settings.form, count, h)
    else:
        found = _true(numeric, sampling, t)
    if settings.form == "continuous" and not numeric.system.discrete:
        return found
    taken = sampled(numeric, t, sampling)[..., None]
    return LocalStack(found.rows * taken, found.error * taken)


def sampled(numeric: NumericSystem, t: Array, sampling: Sampling) -> Flags:
    """Return which outputs are sampled when, shape (k, N, m): by `every` within a window, and `during`."""
    system = numeric.system
    j = np.arange(sampling.samples)
    found = np.ones((len(t), sampling.samples, system.m), dtype=bool)
    for i, (one, every) in enumerate(zip(system.outputs, steps_of(system), strict=True)):
        if every is not None:
            due = np.floor(j * sampling.h / every + _FITS)
            found[:, :, i] &= np.diff(due, prepend=-1.0) > 0
        found[:, :, i] &= sampled_within(system, one, t[:, None] + j * sampling.h, sampling.h)
    return found


def _true(numeric: NumericSystem, sampling: Sampling, t: Array) -> LocalStack:
    """Return R of windows along which A and H vary; windows share the steps between their samples."""
    instants = t[:, None] + sampling.h * np.arange(sampling.samples)
    grid = np.round((instants - t[0]) / (sampling.h * _FITS)).astype(np.int64)
    _, first, place = np.unique(grid, return_index=True, return_inverse=True)
    place = place.reshape(instants.shape)
    shared = instants.ravel()[first]
    found: Coefficients = numeric.coefficients(shared)
    if numeric.system.discrete:
        steps, error = found.A[:-1], found.A_error[:-1] + EPS * np.abs(found.A[:-1])
    else:
        steps, error = sample_transitions(numeric, shared)
    products, product_error = _between(steps, error, place)
    return true_stack(found.H[place], found.H_error[place], products, product_error)


def _between(steps: Array, error: Array, place: Counts) -> tuple[Array, Array]:
    """Return Φ from sample to sample of every window, and its error, (k, N − 1, n, n) each."""
    before, after = place[:, :-1], place[:, 1:]
    if not before.size:
        shape = (*before.shape, *steps.shape[1:])
        return np.zeros(shape), np.zeros(shape)
    product, moved = steps[before], error[before]
    for d in range(1, int((after - before).max())):
        longer = before + d < after
        step, wrong = steps[before[longer] + d], error[before[longer] + d]
        moved[longer] = np.abs(step) @ moved[longer] + wrong @ np.abs(product[longer])
        product[longer] = step @ product[longer]
    return product, moved
