"""Which outputs are sampled when, and with what covariance.

    t_j = t_0 + j · every,  j = 0, 1, …, within the output's ``during``

R is the covariance of one sample where the file says how often there is one (`every`, or `step` of the
noise). Else it is a spectral density: of a mean over ``step`` the covariance is R/step.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from obscli.model.expression import Expression
from obscli.model.system import Output, System
from obscli.numeric.errors import NotComputableError
from obscli.numeric.noise import noise_model
from obscli.numeric.numeric_system import NumericSystem, constants_of
from obscli.numeric.program import Array, Flags, constant_value


#: Samples where the noise is given as a density, and how many instants there may be.
_SAMPLES: Final = 400
_MOST: Final = 2_000_000

#: Instants closer than this, in steps, are one.
_SAME: Final = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Schedule:
    """When the outputs of a system are sampled.

    Parameters
    ----------
    start, stop : the interval
    t : instants with at least one sample, ascending, shape (k,)
    sampled : which outputs are sampled then, shape (k, m)
    R : covariance of the errors of one sample of all outputs, shape (m, m)
    assumed_step : the step taken where R is a density and nothing says how often there is a sample
    """

    start: float
    stop: float
    t: Array
    sampled: Flags
    R: Array
    assumed_step: float | None = None

    @property
    def samples(self) -> int:
        """How many samples of single outputs there are."""
        return int(self.sampled.sum())

    def samples_until(self, done: Array) -> int:
        """Return how many samples of single outputs there are up to the last of some instants."""
        return int(self.sampled[self.t <= done[-1]].sum()) if len(done) else 0


@dataclass(frozen=True, slots=True)
class _Rate:
    """The time between samples of one output; whether R is the covariance of one; the step was assumed."""

    step: float
    per_sample: bool
    assumed: bool = False


def schedule_of(system: System, start: float, stop: float, step: float | None = None) -> Schedule:
    """Return when the outputs are sampled from start to stop.

    Parameters
    ----------
    step : time between samples of the outputs that have no `every`, in place of the file's `step`

    Raises
    ------
    NotComputableError
        where there is no R, a step is not positive, R mixes a density with covariances of samples, or there
        are no samples, or too many
    """
    if not stop > start:
        raise NotComputableError(f"the interval from {start:.6g} to {stop:.6g} is empty: give --from, --to")
    density = _density(system, start, stop)
    rates = [_rate(system, output, start, stop, step) for output in system.outputs]
    constants = constants_of(system)
    each = [
        _instants(output, rate.step, (start, stop), constants)
        for output, rate in zip(system.outputs, rates, strict=True)
    ]
    t, sampled = _joined(each, min((rate.step for rate in rates), default=1.0))
    if not len(t):
        raise NotComputableError(
            f"no output has a sample from {start:.6g} to {stop:.6g}: see `every` and `during` of the outputs"
        )
    if len(t) > _MOST:
        raise NotComputableError(_too_many(len(t)))
    assumed = next((rate.step for rate in rates if rate.assumed), None)
    return Schedule(start, stop, t, sampled, _per_sample(system, density, rates), assumed)


def _density(system: System, start: float, stop: float) -> Array:
    """Return R as the file gives it, (m, m): checked, whatever it means."""
    root = np.linalg.inv(noise_model(NumericSystem(system, start, stop)).whitening)
    noise = system.noise
    step = 1.0 if noise is None or noise.step is None else constant_value(noise.step, constants_of(system))
    R: Array = root @ root.T / step
    return R


def _rate(system: System, output: Output, start: float, stop: float, step: float | None) -> _Rate:
    given = system.noise.step if system.noise else None
    if output.every is not None:
        return _Rate(_positive(system, output.every, f"`every` of {output.name}"), per_sample=True)
    if step is not None:
        if not (step > 0 and np.isfinite(step)):
            raise NotComputableError(f"the step between samples must be positive, not {step:g} (--step)")
        return _Rate(step, per_sample=given is not None)
    if given is not None:
        return _Rate(_positive(system, given, "`noise: step`"), per_sample=True)
    return _Rate((stop - start) / _SAMPLES, per_sample=False, assumed=True)


def _positive(system: System, entry: Expression, name: str) -> float:
    value = _number(entry, constants_of(system), name)
    if value <= 0:
        raise NotComputableError(f"{name} must be positive, not {value:g}")
    return value


def _number(entry: Expression, constants: dict[str, float], name: str) -> float:
    try:
        value = constant_value(entry, constants)
    except KeyError as error:
        raise NotComputableError(
            f"{name} depends on {error.args[0]}: only constants with values are taken"
        ) from None
    if not np.isfinite(value):
        raise NotComputableError(f"{name} is not finite")
    return value


def _instants(
    output: Output, step: float, interval: tuple[float, float], constants: dict[str, float]
) -> Array:
    """Return the instants at which one output is sampled."""
    start, stop = interval
    count = int((stop - start) / step + _SAME) + 1
    if count > _MOST:
        raise NotComputableError(_too_many(count))
    t: Array = np.minimum(start + step * np.arange(count), stop)
    if output.during is None:
        return t
    inside = np.zeros(count, dtype=bool)
    for pair in output.during:
        first, last = (_number(one, constants, f"`during` of {output.name}") for one in pair)
        inside |= (t >= first - _SAME * step) & (t <= last + _SAME * step)
    return t[inside]


def _joined(each: Sequence[Array], step: float) -> tuple[Array, Flags]:
    """Return the instants of all outputs, one where they agree to rounding, and which outputs have them."""
    t = np.concatenate([*each, np.empty(0)])
    which = np.repeat(np.arange(len(each)), [len(one) for one in each])
    order = np.argsort(t, kind="stable")
    t, which = t[order], which[order]
    fresh = np.diff(t, prepend=-np.inf) > _SAME * step
    sampled = np.zeros((int(fresh.sum()), len(each)), dtype=bool)
    sampled[fresh.cumsum() - 1, which] = True
    return t[fresh], sampled


def _per_sample(system: System, R: Array, rates: Sequence[_Rate]) -> Array:
    kinds = np.array([rate.per_sample for rate in rates])
    for i, j in zip(*np.nonzero(R * (kinds[:, None] != kinds)), strict=True):
        a, b = system.outputs[i].name, system.outputs[j].name
        raise NotComputableError(
            f"`noise: R` correlates {a} with {b}, but is a density for one and a covariance per sample for "
            "the other: give both `every`, or the noise a `step`"
        )
    steps = np.array([1.0 if rate.per_sample else rate.step for rate in rates])
    scaled: Array = R / np.sqrt(steps[:, None] * steps)
    return scaled


def _too_many(count: int) -> str:
    return (
        f"{count} instants with samples: {_MOST} at the most; shorten the interval (--to), or take "
        "fewer samples (--step)"
    )
