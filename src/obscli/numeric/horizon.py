"""The instants t_1 … t_N at which the Gramian W(t_i, t_0) is wanted, and where they come from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from obscli.model.expression import Expression
from obscli.model.system import System
from obscli.numeric.errors import NotComputableError, UnfitRequestError
from obscli.numeric.numeric_system import NumericSystem, constants_of
from obscli.numeric.program import Array, constant_value
from obscli.numeric.rates import rates_of
from obscli.numeric.signals import Samples, overlap, require_covered, samples_of


#: Instants where nobody says how many, and how large a system may be for that many.
SAMPLES: Final = 150
FEWEST_SAMPLES: Final = 10
EASY_STATES: Final = 50

#: The default interval in units of the fastest rate.
SPANS: Final = 20


@dataclass(frozen=True, slots=True, eq=False)
class Wanted:
    """What the user asks of the instants, as expressions; None: as in the file."""

    start: Expression | None = None
    stop: Expression | None = None
    samples: int | None = None
    times: tuple[Expression, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Horizon:
    """t_0, the instants t_i > t_0 in order, and whether the interval is given or a default.

    ``end``: of a discrete-time system the last sample, which instants look forward to.
    """

    start: float
    instants: Array
    origin: Literal["given", "default"]
    end: float | None = None

    @property
    def stop(self) -> float:
        """The end of the interval: the last instant, or the last sample."""
        return float(self.instants[-1]) if self.end is None else self.end


def horizon_of(system: System, wanted: Wanted) -> Horizon:
    """Return the instants: those wanted, else evenly over the file's interval, else over a default one.

    The default is what all files of signals cover; without signals 20 over the fastest rate, from 0.

    Raises
    ------
    NotComputableError
        where an end is no number, or the instants do not follow the start (``UnfitRequestError`` where the
        user asked for them)
    """
    if system.discrete:
        from obscli.numeric.discrete_horizon import discrete_horizon  # noqa: PLC0415 - built on this file

        return discrete_horizon(system, wanted)
    given, files = system.interval, samples_of(system) if system.sampled else ()
    asked = wanted.start is not None or wanted.stop is not None
    start_given = wanted.start or (given.start if given else None)
    start = _default_start(files) if start_given is None else number_of(system, start_given, "the start")
    if wanted.times:
        instants = np.unique([number_of(system, one, "an instant") for one in wanted.times])
        if instants[0] <= start:
            raise UnfitRequestError(
                f"the instant {instants[0]:.6g} is not after the start {start:.6g} of the interval "
                "(--from moves the start)"
            )
        if files:
            require_covered(files, start, float(instants[-1]), asked=True)
        return Horizon(start, instants, "given")
    stop_given = wanted.stop or (given.stop if given else None)
    origin: Literal["given", "default"] = "given" if stop_given is not None else "default"
    if stop_given is not None:
        stop = number_of(system, stop_given, "the stop")
    else:
        stop = overlap(files)[1] if files else _default_stop(system, start)
    if files and start < stop:
        require_covered(files, start, stop, asked=asked)
    if stop <= start:
        unfit = UnfitRequestError if asked else NotComputableError
        raise unfit(f"the interval stops at {stop:.6g}, not after its start {start:.6g}")
    samples = wanted.samples or (given.samples if given else None) or default_samples(system.n)
    return Horizon(start, start + (stop - start) * np.arange(1, samples + 1) / samples, origin)


def _default_start(files: tuple[Samples, ...]) -> float:
    return overlap(files)[0] if files else 0.0


def default_samples(n: int) -> int:
    """Return how many instants are taken for n states: fewer for large systems."""
    return max(FEWEST_SAMPLES, round(SAMPLES * min(1.0, (EASY_STATES / n) ** 2)))


def number_of(system: System, expression: Expression, what: str) -> float:
    """Return a number at the file's values; ``what`` it is, in words.

    Raises
    ------
    NotComputableError
        where it is none
    """
    try:
        value = constant_value(expression, constants_of(system))
    except (KeyError, TypeError):
        raise NotComputableError(f"{what} of the interval must be a number at the file's values") from None
    if not np.isfinite(value):
        raise NotComputableError(f"{what} of the interval is not finite")
    return value


def _default_stop(system: System, start: float) -> float:
    """Return 20/(fastest rate found), a rate of 1 being taken where nothing has one."""
    at_unit_rate = start + SPANS
    probe = NumericSystem(system, start, at_unit_rate)
    found = rates_of(probe, np.array([start + 1e-3 * SPANS / 7, start + 0.1 * SPANS]))
    tones = probe.motion.rate if probe.motion else 0.0
    rates = [rate for rate in (found.coefficients, found.dynamics) if rate > 0 and rate != tones]
    return start + SPANS / max(rates) if rates else at_unit_rate
