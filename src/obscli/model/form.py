"""Scalars that are affine in the states (or inputs): constant + Σ coefficient·state.

Everything a file computes is made of these; a product of two states is refused here, by name.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Final

from obscli.model.constants import apply_function, root_of
from obscli.model.expression import (
    ONE,
    ZERO,
    Apply,
    Expression,
    Number,
    Product,
    Sum,
    Symbol,
    add,
    is_zero,
    multiply,
    negate,
    power,
)


LARGEST_POWER: Final = 10_000
MOST_BITS: Final = 40_000


class Impossible(Exception):  # noqa: N818
    """An operation these values do not allow."""

    def __init__(self, message: str, hint: str = "") -> None:
        self.message, self.hint = message, hint
        super().__init__(message)


@dataclass(frozen=True, slots=True, eq=False)
class Form:
    """constant + Σ linear[name]·name; the names are states, inputs or disturbances."""

    constant: Expression = ZERO
    linear: Mapping[str, Expression] = field(default_factory=dict)


ZERO_FORM: Final = Form()
ONE_FORM: Final = Form(ONE)


def is_zero_form(form: Form) -> bool:
    """Whether the form is 0 as written."""
    return not form.linear and is_zero(form.constant)


def bits(node: Expression) -> int:
    """Return the length of the number in front of a node."""
    if isinstance(node, Sum):
        node = node.terms[0]
    elif isinstance(node, Product):
        node = node.factors[0]
    if not isinstance(node, Number):
        return 0
    return node.value.numerator.bit_length() + node.value.denominator.bit_length()


def _guard(nodes: Iterable[Expression]) -> None:
    if sum(bits(node) for node in nodes) > MOST_BITS:
        raise Impossible("the numbers here grow beyond thousands of digits")


def total(forms: Iterable[Form]) -> Form:
    """Return the sum of the forms."""
    forms = [form for form in forms if not is_zero_form(form)]
    if len(forms) <= 1:
        return forms[0] if forms else ZERO_FORM
    parts: dict[str, list[Expression]] = {}
    for form in forms:
        for name, coefficient in form.linear.items():
            parts.setdefault(name, []).append(coefficient)
    linear = {name: _sum(nodes) for name, nodes in parts.items()}
    constant = _sum([form.constant for form in forms])
    return Form(constant, {name: node for name, node in linear.items() if not is_zero(node)})


def _sum(nodes: list[Expression]) -> Expression:
    _guard(nodes)
    return add(*nodes)


def product(left: Form, right: Form) -> Form:
    """Return the product; one of the two must be free of states."""
    if left.linear and right.linear:
        raise Impossible(
            f"not linear in the states: {_named(left)} is multiplied by {_named(right)}",
            "give the linearised right-hand side (`linearize` is not supported yet)",
        )
    if is_zero_form(left) or is_zero_form(right):
        return ZERO_FORM
    constant = _times(left.constant, right.constant)
    if left.linear:
        return Form(constant, {name: _times(node, right.constant) for name, node in left.linear.items()})
    return Form(constant, {name: _times(left.constant, node) for name, node in right.linear.items()})


def _times(left: Expression, right: Expression) -> Expression:
    _guard((left, right))
    same = isinstance(left, Symbol) and isinstance(right, Symbol) and left.name == right.name
    return power(left, 2) if same else multiply(left, right)


def opposite(form: Form) -> Form:
    """Return −form."""
    return Form(negate(form.constant), {name: negate(node) for name, node in form.linear.items()})


def quotient(left: Form, right: Form) -> Form:
    """Return left / right; the divisor must be free of states and not 0."""
    return product(left, Form(raised(constant_of(right, "in a divisor"), Fraction(-1))))


def constant_of(form: Form, how: str) -> Expression:
    """Return the form as an expression free of states."""
    if form.linear:
        raise Impossible(
            f"not linear in the states: '{next(iter(form.linear))}' stands {how}",
            "give the linearised right-hand side (`linearize` is not supported yet)",
        )
    return form.constant


def _named(form: Form) -> str:
    return f"'{next(iter(form.linear))}'"


def raised(base: Expression, exponent: Fraction) -> Expression:
    """Return the base to a rational power, within the limits."""
    if max(abs(exponent.numerator), exponent.denominator) > LARGEST_POWER:
        raise Impossible(f"powers beyond {LARGEST_POWER} are refused")
    if isinstance(base, Number):
        return _number_raised(base.value, exponent)
    result = power(base, exponent)
    reached = getattr(result, "exponent", exponent)
    if max(abs(reached.numerator), reached.denominator) > LARGEST_POWER:
        raise Impossible(f"powers beyond {LARGEST_POWER} are refused")
    return result


def _number_raised(base: Fraction, exponent: Fraction) -> Expression:
    if base == 0 and exponent < 0:
        raise Impossible("division by zero")
    if base < 0 and exponent.denominator != 1:
        raise Impossible("a root of a negative number is not real")
    if exponent.denominator != 1:
        return root_of(base, exponent)
    if abs(exponent) * (base.numerator.bit_length() + base.denominator.bit_length()) > MOST_BITS:
        raise Impossible("the numbers here grow beyond thousands of digits")
    return power(Number(base), exponent)


def exponential(base: Form, exponent: Form) -> Form:
    """Return base ^ exponent: a power for a rational exponent, else exp(exponent·log(base))."""
    above = constant_of(exponent, "in an exponent")
    if isinstance(above, Number):
        if above.value == 1:
            return base
        return Form(raised(constant_of(base, "under a power"), above.value))
    logarithm = applied("log", Form(constant_of(base, "under a power")))
    return applied("exp", product(Form(above), logarithm))


def applied(function: str, argument: Form) -> Form:
    """Return an elementary function of the form, which must be free of states."""
    inner = constant_of(argument, f"inside {function}")
    known = apply_function(function, inner)
    if isinstance(known, str):
        raise Impossible(known)
    return Form(known if known is not None else Apply(function, inner))
