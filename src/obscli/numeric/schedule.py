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

from obscli.model.expression import symbols
from obscli.model.system import Output, System
from obscli.numeric.errors import NotComputableError, UnfitRequestError
from obscli.numeric.noise import NoiseModel, noise_model, steps_of
from obscli.numeric.numeric_system import NumericSystem, constants_of, missing_values
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


def schedule_of(system: System, start: float, stop: float, step: float | None = None) -> Schedule:
    """Return when the outputs are sampled from start to stop.

    Parameters
    ----------
    step : time between samples of the outputs that have no `every`, in place of the file's `step`

    Raises
    ------
    NotComputableError
        where there is no R, a step is not positive, or there are no samples, or too many
    """
    if not stop > start:
        raise NotComputableError(f"the interval from {start:.6g} to {stop:.6g} is empty: give --from, --to")
    if step is not None and not (step > 0 and np.isfinite(step)):
        raise NotComputableError(f"the step between samples must be positive, not {step:g} (--step)")
    density = _density(noise_model(NumericSystem(system, start, stop)))
    if system.discrete and step is not None:
        raise UnfitRequestError(
            "--step is the time between samples of a continuous-time model; outputs of a discrete-time one "
            "are sampled at every step, or `every` so many"
        )
    given = steps_of(system)
    assumed = (stop - start) / _SAMPLES if step is None and None in given else None
    steps = np.array([_step(*one, step, assumed) for one in zip(system.outputs, given, strict=True)])
    each = [_instants(system, *one, (start, stop)) for one in zip(system.outputs, steps, strict=True)]
    t, sampled = _joined(each, float(steps.min(initial=stop - start)))
    if not len(t):
        raise NotComputableError(
            f"no output has a sample from {start:.6g} to {stop:.6g}: see `every` and `during` of the outputs"
        )
    if len(t) > _MOST:
        raise NotComputableError(_too_many(len(t)))
    # R per sample where the file says how often there is one: another step leaves it as it is
    meant = np.array([step if own is None else own for step, own in zip(steps, given, strict=True)])
    if system.discrete:
        meant = np.ones(len(steps))  # R is that of a sample, however many steps there are between two
    return Schedule(start, stop, t, sampled, density / np.sqrt(np.outer(meant, meant)), assumed)


def _density(noise: NoiseModel) -> Array:
    """Return R as a density, shape (m, m)."""
    root = np.linalg.inv(noise.whitening)
    return np.asarray(root @ root.T, dtype=float)


def _step(output: Output, given: float | None, asked: float | None, assumed: float | None) -> float:
    """Return the time between samples of an output: its own, else as asked, else the file's, else assumed."""
    candidates = (given if output.every is not None else None, asked, given, assumed)
    return next(one for one in candidates if one is not None)


def _instants(system: System, output: Output, step: float, interval: tuple[float, float]) -> Array:
    """Return the instants at which one output is sampled."""
    start, stop = interval
    count = int((stop - start) / step + _SAME) + 1
    if count > _MOST:
        raise NotComputableError(_too_many(count))
    t: Array = np.minimum(start + step * np.arange(count), stop)
    return t if output.during is None else t[sampled_within(system, output, t, step)]


def sampled_within(system: System, output: Output, t: Array, step: float) -> Flags:
    """Return at which instants an output is sampled, but for outages; ends count within rounding of a step.

    Raises
    ------
    NotComputableError
        where a parameter in `during` has no value
    """
    if output.during is None:
        return np.ones(t.shape, dtype=bool)
    inside = np.zeros(t.shape, dtype=bool)
    constants = constants_of(system)
    for pair in output.during:
        if unknown := symbols(*pair) - constants.keys():
            raise NotComputableError(f"`during` of {output.name}: {missing_values(sorted(unknown))}")
        first, last = (constant_value(one, constants) for one in pair)
        inside |= (t >= first - _SAME * step) & (t <= last + _SAME * step)
    return inside


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


def _too_many(count: int) -> str:
    return (
        f"{count} instants with samples: {_MOST} at the most; shorten the interval (--to), or take "
        "fewer samples (--step)"
    )
