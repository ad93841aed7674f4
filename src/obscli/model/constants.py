"""Exact values of functions at exact numbers: sin(pi/6), sqrt(4), log(1), and what is undefined."""

from __future__ import annotations

from fractions import Fraction
from math import isqrt
from typing import Final

from obscli.model.expression import (
    ONE,
    ZERO,
    Expression,
    Number,
    Pi,
    Power,
    Product,
    Sum,
    multiply,
    negate,
    number,
    power,
)


#: Rational multiples of π in [0, 1/2] and the squares of their sines.
_SINE_SQUARES: Final = {
    Fraction(0): Fraction(0),
    Fraction(1, 6): Fraction(1, 4),
    Fraction(1, 4): Fraction(1, 2),
    Fraction(1, 3): Fraction(3, 4),
    Fraction(1, 2): Fraction(1),
}
_AT_ZERO: Final = {
    "sin": ZERO, "tan": ZERO, "asin": ZERO, "atan": ZERO, "exp": ONE, "cos": ONE,
    "sinh": ZERO, "tanh": ZERO, "asinh": ZERO, "atanh": ZERO, "cosh": ONE,
}  # fmt: skip


def multiple_of_pi(node: Expression) -> Fraction | None:
    """Return r where the node is r·π as written, else None."""
    match node:
        case Number(value) if value == 0:
            return Fraction(0)
        case Pi():
            return Fraction(1)
        case Product((Number(value), Pi())):
            return value
        case Sum(terms):
            parts = [multiple_of_pi(term) for term in terms]
            known = [part for part in parts if part is not None]
            return sum(known, Fraction(0)) if len(known) == len(parts) else None
    return None


def sine(turns: Fraction) -> Expression | None:
    """Return sin(turns·π) where it is a rational or the root of one."""
    turns %= 2
    sign = -1 if turns >= 1 else 1
    half = turns % 1
    square = _SINE_SQUARES.get(min(half, 1 - half))
    if square is None:
        return None
    return multiply(number(sign), root_of(square, Fraction(1, 2))) if square else ZERO


def root_of(base: Fraction, exponent: Fraction) -> Expression:
    """Return base^exponent for base ≥ 0; square roots of squares are taken, √(1/2) is √2/2."""
    if base in (0, 1):
        return number(base)
    if exponent.denominator != 2 or max(base.numerator, base.denominator) > 10**60:
        return Power(Number(base), exponent)
    top, bottom = base.numerator, base.denominator
    if isqrt(top) ** 2 == top and isqrt(bottom) ** 2 == bottom:
        return power(Number(Fraction(isqrt(top), isqrt(bottom))), exponent.numerator)
    if exponent != Fraction(1, 2):
        return Power(Number(base), exponent)
    outer, inner = 1, top * bottom
    for prime in (2, 3, 5, 7, 11, 13):
        while inner % prime**2 == 0:
            inner, outer = inner // prime**2, outer * prime
    return multiply(Number(Fraction(outer, bottom)), Power(number(inner), exponent))


def apply_function(function: str, node: Expression) -> Expression | str | None:
    """Return the exact value, None where there is none, or a text saying why it is undefined."""
    if isinstance(node, Number):
        undefined = _undefined(function, node.value)
        if undefined:
            return f"{function}({node.value}) is not a real number"
        if node.value == 0 and function in _AT_ZERO:
            return _AT_ZERO[function]
        if node.value == 1 and function in {"log", "acos", "acosh"}:
            return ZERO
    return _trigonometric(function, node) if function in {"sin", "cos", "tan"} else None


def _trigonometric(function: str, node: Expression) -> Expression | str | None:
    turns = multiple_of_pi(node)
    if turns is None:
        return None
    if function != "tan":
        return sine(turns if function == "sin" else turns + Fraction(1, 2))
    half = turns % 1
    if half == Fraction(1, 2):
        return "tan is infinite here"
    square = _SINE_SQUARES.get(min(half, 1 - half))
    if square is None:
        return None
    size = root_of(square / (1 - square), Fraction(1, 2))
    return size if half < Fraction(1, 2) else negate(size)


def _undefined(function: str, value: Fraction) -> bool:
    match function:
        case "log":
            return value <= 0
        case "asin" | "acos":
            return abs(value) > 1
        case "acosh":
            return value < 1
        case "atanh":
            return abs(value) >= 1
    return False
