"""The period of a system at the file's values, where everything that varies has one.

A base angle θ of constant rate has the period 2π/|θ'|; of several angles the periods must be in rational
proportion, P = lcm of them. Time itself, exponentials and functions left open have none.
"""

from __future__ import annotations

from fractions import Fraction
from functools import reduce as fold
from math import gcd, lcm, pi
from typing import TYPE_CHECKING

from obscli.exact.ball import precision
from obscli.exact.hidden_dynamics import occurring, rate
from obscli.exact.there import balls_there


if TYPE_CHECKING:
    from obscli.exact.field import Element
    from obscli.exact.prove import Proof

_BITS = 128


def period(proof: Proof) -> float | None:
    """Return the period of A and H in units of time; None where there is none, or a value is missing."""
    exact = proof.exact
    entries = [e for row in (*exact.A, *exact.H) for e in row.values()]
    varying = {k for e in entries for k in occurring(e) if exact.field.varies(k)}
    rates = [rate(proof, k) for k in varying]
    known = [one for one in rates if one is not None]
    if not known or len(known) < len(rates):
        return None
    ratios = [(one / known[0]).rational for one in known]
    first = _value(proof, known[0])
    if first is None or any(ratio is None for ratio in ratios):
        return None
    return 2 * pi / abs(first) * float(_multiple([ratio for ratio in ratios if ratio is not None]))


def _multiple(ratios: list[Fraction]) -> Fraction:
    """Return the least m with m·r whole for every r: the common period in periods of the first."""
    return Fraction(lcm(*(r.denominator for r in ratios)), fold(gcd, (abs(r.numerator) for r in ratios)))


def _value(proof: Proof, element: Element) -> float | None:
    with precision(_BITS, 1):
        balls = balls_there(proof.exact.interpreter, [element])
        return None if balls is None else float(balls[0].mid())
