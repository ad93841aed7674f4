"""The steps k_1 … k_N of a discrete-time system at which the Gramian is wanted, and the last sample K.

The time symbol counts steps, and so do the ends of the interval: whole numbers. Every instant has the outputs
from there to K: where nobody asks for others, n samples at least, which show all that constant F and H do.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from obscli.numeric.errors import NotComputableError, UnfitRequestError
from obscli.numeric.horizon import Horizon, default_samples, number_of


if TYPE_CHECKING:
    from obscli.model.system import System
    from obscli.numeric.horizon import Wanted
    from obscli.numeric.program import Array

#: The default interval: so many steps, and more than so many for every state.
_STEPS: Final = 20
_PER_STATE: Final = 2

_WHOLE: Final = 1e-9


def discrete_horizon(system: System, wanted: Wanted) -> Horizon:
    """Return the steps: those wanted, else those of the file's interval, else of a default one.

    Raises
    ------
    NotComputableError
        where an end is no whole number, or the interval is empty (``UnfitRequestError`` where the user asked)
    """
    given = system.interval
    start_given = wanted.start or (given.start if given else None)
    stop_given = wanted.stop or (given.stop if given else None)
    start = (
        0.0
        if start_given is None
        else whole(number_of(system, start_given, "the start"), "the start of the interval")
    )
    origin: Literal["given", "default"] = "given" if stop_given is not None else "default"
    if stop_given is None:
        stop = start + max(_STEPS, _PER_STATE * system.n)
    else:
        stop = whole(number_of(system, stop_given, "the stop"), "the stop of the interval")
    if wanted.times:
        instants = np.unique([_asked(number_of(system, t, "an instant")) for t in wanted.times])
        if stop_given is None:
            stop = max(stop, instants[-1] + stop - start)
        outside = (instants < start) | (instants > stop)
        if outside.any():
            raise UnfitRequestError(
                f"the step {instants[outside][0]:.6g} is not within {start:.6g} to {stop:.6g} (--from, --to)"
            )
        return Horizon(start, instants, "given", stop)
    if stop <= start:
        asked = wanted.start is not None or wanted.stop is not None
        unfit = UnfitRequestError if asked else NotComputableError
        raise unfit(f"the interval stops at {stop:.6g}, not after its start {start:.6g}")
    samples = wanted.samples or (given.samples if given else None) or default_samples(system.n)
    return Horizon(start, _spread(start, max(start, stop - system.n + 1), samples), origin, stop)


def _asked(value: float) -> float:
    try:
        return whole(value, "an instant")
    except NotComputableError as error:
        raise UnfitRequestError(str(error)) from error


def _spread(start: float, stop: float, samples: int) -> Array:
    """Return so many steps, evenly from start to stop; all of them where they are no more."""
    count = int(stop - start) + 1
    chosen: Array = start + np.unique(np.round(np.linspace(0, count - 1, min(samples, count))))
    return chosen


def whole(value: float, what: str) -> float:
    """Return a number of steps.

    Raises
    ------
    NotComputableError
        where it is no whole number
    """
    nearest = float(np.round(value))
    if abs(value - nearest) > _WHOLE * max(1.0, abs(value)):
        raise NotComputableError(f"{what} is {value:.6g}: a discrete-time model counts steps, whole numbers")
    return nearest
