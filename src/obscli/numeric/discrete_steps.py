"""A discrete-time system step by step, as the filters take it.

    x(k+1) = F(k) x(k) + G(k) w(k),   y(k) = H(k) x(k) + v(k)

A stretch is one step: its coordinates are those of its own instant, so that Φ is I there, and F takes them on
to the next stretch. The noise that has entered since the step before is G(k−1) Q^½. Nothing is inverted.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

import numpy as np

from obscli.numeric.errors import NotComputableError
from obscli.numeric.program import Array, Counts


if TYPE_CHECKING:
    from obscli.numeric.noise import NoiseModel
    from obscli.numeric.numeric_system import NumericSystem

#: Steps worked on at a time.
_AT_ONCE: Final = 4000

_WHOLE: Final = 1e-9


def steps_between(start: float, stop: float) -> Array:
    """Return the steps from start to stop, both of them."""
    return np.arange(start, stop + 1)


def require_whole(t: Array) -> None:
    """Refuse instants between two steps.

    Raises
    ------
    NotComputableError
        naming the first of them
    """
    between = np.abs(t - np.round(t)) > _WHOLE
    if between.any():
        raise NotComputableError(
            f"{t[between][0]:.6g} lies between two steps: a discrete-time model counts whole steps"
        )


def single_steps(
    numeric: NumericSystem, noise: NoiseModel, t: Array
) -> Iterator[tuple[int, Array, Array, Array | None]]:
    """Yield, of every step, its number, F (n, n), H (m, n), the root of the noise entered since the last.

    Raises
    ------
    NotComputableError
        where a coefficient does not exist at some step
    """
    require_whole(t)
    for begin in range(0, len(t), _AT_ONCE):
        part: Counts = np.arange(begin, min(begin + _AT_ONCE, len(t)))
        F, H = numeric.matrices(t[part])
        driving = None if noise.drive is None else noise.driving(t[part] - 1)
        if driving is not None and not np.isfinite(driving[int(begin == 0) :]).all():
            raise NotComputableError(f"G does not exist at some step from {t[part][0]:.6g}")
        for k in part:
            entered = None if driving is None else driving[k - begin]
            if entered is not None and k == 0:
                entered = np.zeros_like(entered)
            yield int(k), F[k - begin], H[k - begin], entered
