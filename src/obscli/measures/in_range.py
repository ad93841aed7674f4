"""Balls as numbers in double precision, where they fit.

Rounding makes nothing 0 or ∞ that is not: what is smaller or larger than double precision holds has no value.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from flint import arb


if TYPE_CHECKING:
    from obscli.measures.subject import Subject


_BITS: Final = 50
_SMALLEST: Final = float(np.finfo(float).tiny)
_LARGEST: Final = float(np.finfo(float).max)


def as_double(value: arb) -> float | None:
    """Return a ball as a number, zero if it holds zero; None where it is beyond double precision, or wide."""
    if value.contains(0):
        return 0.0
    fits = _SMALLEST <= abs(value) <= _LARGEST and value.rel_accuracy_bits() >= _BITS
    return float(value) if fits else None


def or_nan(value: float | None) -> float:
    """Return a value of the system as a whole: not a number where there is none."""
    return math.nan if value is None else value


def of_states(subject: Subject, values: Sequence[float | None]) -> tuple[float | None, ...]:
    """Return values of the states as those of all targets, None for the others."""
    each = iter(values)
    return tuple(next(each) if is_state else None for is_state in subject.is_state)


def beyond(count: int, what: str = "value") -> tuple[str, ...]:
    """Return the remark on so many values that are beyond double precision; none on none."""
    if not count:
        return ()
    many = f"{count} {what}s are" if count > 1 else f"a {what} is"
    return (f"{many} beyond the range of double precision: choose other units of the states (--scaling)",)
