"""The Gramian of a discrete-time system as a square root, from the last sample backwards.

    W(k, K) = Σ_{j=k}^{K} Φᵀ(j, k) Hᵀ(j) H(j) Φ(j, k),    Φ(j, k) = F(j−1) … F(k)
    R(K) = H(K),    R(k) ← qr [R(k+1) F(k); H(k)],    W(k, K) = R(k)ᵀ R(k)

It is that of x(k) from the outputs at k, k + 1, …, K. Nothing is inverted, so F may be singular: a direction
that F takes to zero is observable at k where H(k) sees it, and not afterwards. The error is carried along as
``square_root`` does.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from obscli.numeric.errors import TooManyStepsError
from obscli.numeric.gramian import Gramian
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.panels import Panels
from obscli.numeric.program import EPS, Array
from obscli.numeric.square_root import carried


MOST_STEPS: Final = 200_000

#: Numbers (of 8 bytes) worked on at a time.
_CHUNK: Final = 2_000_000


@dataclass(frozen=True, slots=True, eq=False)
class _Steps:
    """The system as its rows are carried: every row of F is given."""

    n: int
    moving: Array


def discrete_gramian(system: NumericSystem, instants: Array, last: float) -> Gramian:
    """Return R(k) for W(k, K) at steps k; R = 0 with error ``LOST`` where columns grow too far.

    Parameters
    ----------
    instants : k in order, whole numbers, none after the last, shape (N,)
    last : K

    Raises
    ------
    NotComputableError
        where a coefficient does not exist at some step, or the steps are too many
    """
    if last - instants[0] > MOST_STEPS:
        raise TooManyStepsError(f"more than {MOST_STEPS} steps: choose a shorter interval (--from, --to)")
    steps = _Steps(system.n, system.moving)
    found = carried(_backwards(system, instants[0], last), steps, last, instants[::-1])
    return replace(
        found,
        instants=found.instants[::-1],
        matrices=found.matrices[::-1],
        units=found.units[::-1],
        error=found.error[::-1],
        growth=found.growth[::-1],
    )


def _backwards(system: NumericSystem, first: float, last: float) -> Iterator[Panels]:
    """Yield F(k), H(k) with their errors, from the last step to the first, in pieces that fit into memory."""
    at_once = max(_CHUNK // (system.n * (system.n + system.m)), 1)
    every = np.arange(last, first - 1, -1)
    for begin in range(0, len(every), at_once):
        k = every[begin : begin + at_once]
        found = system.coefficients(k)
        sums = EPS * np.abs(found.A)
        yield Panels(
            ends=k,
            transition=found.A,
            rows=found.H,
            transition_error=found.A_error**2 + sums**2,
            row_error=(found.H_error**2).sum(axis=1),
        )


def refined(system: NumericSystem, k: float, last: float, window: float) -> Gramian:
    """Return the Gramian at one step from so many samples after it, none beyond the last."""
    return discrete_gramian(system, np.array([k]), min(last, k + max(np.ceil(window), 1.0)))
