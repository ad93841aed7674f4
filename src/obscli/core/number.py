"""The one place where a float, or a count of things, becomes text."""

from __future__ import annotations

import math


def short(value: float, digits: int = 2) -> str:
    """Return a number in few digits: 16, 0.094, 2.7e-07 as 2.7e-7.

    >>> short(2.7e-7), short(0.0942), short(1500.0), short(float("inf"))
    ('2.7e-7', '0.094', '1500', 'inf')
    """
    if not math.isfinite(value):
        return "inf" if value > 0 else "-inf" if value < 0 else "–"
    if value == 0:
        return "0"
    if value == round(value) and abs(value) < 1e6:
        return str(round(value))
    text = f"{value:.{digits}g}"
    mantissa, exponent, power = text.partition("e")
    return f"{mantissa}e{int(power)}" if exponent else text


def plain(value: float) -> str:
    """Return a number with all the digits that matter to a reader of a table of instants."""
    return short(value, 6)


def json_number(value: float | None) -> float | str | None:
    """Return a number as JSON takes it: infinity as text, not a number as null."""
    if value is None or math.isnan(value):
        return None
    if math.isinf(value):
        return "inf" if value > 0 else "-inf"
    return float(value)


def counted(count: int, noun: str) -> str:
    """Return ``1 state``, ``2 states``."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def bar(done: int, of: int, width: int = 20) -> str:
    """Return how far something is as a bar with its count.

    >>> bar(5, 20)
    '━━━━━─────────────── 5 of 20'
    """
    filled = round(width * min(done / max(of, 1), 1.0))
    return f"{'━' * filled}{'─' * (width - filled)} {done} of {of}"
