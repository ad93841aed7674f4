"""Scalars to first order in the states (or inputs): constant + Σ coefficient·state.

Everything a file computes is made of these. About a nominal point x̄ (``linearize``) the constant is f(x̄), the
coefficients are ∂f/∂x at x̄, carried along by the rules of differentiation:

    (a + A)(b + B) = ab + bA + aB,    f(a + A) = f(a) + f'(a) A

Without a value for a state everything has to be linear in it; what is not is refused here, by name.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
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
    Power,
    Product,
    Sum,
    Symbol,
    add,
    children,
    derivative_of,
    is_zero,
    multiply,
    negate,
    postorder,
    power,
    rebuild,
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
    """constant + Σ linear[name]·name; the names are states, inputs or disturbances.

    ``held``: the names whose nominal values the constant is taken at; None: there is no nominal point here.
    Of the other names the constant holds no value: it may be added to, but not multiplied into a coefficient.
    A name held may have the coefficient 0: the square of x depends on x at x = 0 too, and its root has no
    derivative there.
    """

    constant: Expression = ZERO
    linear: Mapping[str, Expression] = field(default_factory=dict)
    held: frozenset[str] | None = None

    @property
    def open_names(self) -> tuple[str, ...]:
        """The names that the form depends on without a value of theirs."""
        return tuple(name for name in self.linear if name not in (self.held or ()))


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
    held = next((form.held for form in forms if form.held is not None), None)
    kept = {name: node for name, node in linear.items() if name in (held or ()) or not is_zero(node)}
    return Form(constant, kept, held)


def _sum(nodes: list[Expression]) -> Expression:
    _guard(nodes)
    return add(*nodes)


def product(left: Form, right: Form) -> Form:
    """Return the product; one of the two must be free of states, or both have values."""
    if left.linear and right.linear:
        _require_values(left, right)
        if left is right:
            return _raised_form(left, Fraction(2), "under a power")
    if is_zero_form(left) or is_zero_form(right):
        return ZERO_FORM
    constant = _times(left.constant, right.constant)
    by_left = Form(constant, _scaled(left.linear, right.constant), left.held)
    by_right = Form(ZERO, _scaled(right.linear, left.constant), right.held)
    return total((by_left, by_right)) if left.linear and right.linear else _either(by_left, by_right)


def _either(by_left: Form, by_right: Form) -> Form:
    return Form(by_left.constant, by_right.linear, by_right.held) if by_right.linear else by_left


def _scaled(linear: Mapping[str, Expression], factor: Expression) -> dict[str, Expression]:
    return {name: _times(node, factor) for name, node in linear.items()}


def _require_values(left: Form, right: Form) -> None:
    """Refuse the product of two forms in states where not all of them have values."""
    missing = tuple(dict.fromkeys((*left.open_names, *right.open_names)))
    if missing:
        first, second = ((*form.open_names, *form.linear)[0] for form in (left, right))
        message = f"not linear in the states: '{first}' is multiplied by '{second}'"
        raise Impossible(message, _remedy(left, missing))


def _remedy(form: Form, missing: tuple[str, ...]) -> str:
    if form.held is None:
        return "a linear combination of the states is expected"
    pairs = ", ".join(f"{name}: …" for name in missing[:3])
    return f"give the value to linearise about: `linearize: {{trajectory: {{{pairs}}}}}`"


def _times(left: Expression, right: Expression) -> Expression:
    _guard((left, right))
    same = isinstance(left, Symbol) and isinstance(right, Symbol) and left.name == right.name
    return power(left, 2) if same else multiply(left, right)


def opposite(form: Form) -> Form:
    """Return −form."""
    linear = {name: negate(node) for name, node in form.linear.items()}
    return Form(negate(form.constant), linear, form.held)


def quotient(left: Form, right: Form) -> Form:
    """Return left / right; the divisor must not be 0."""
    return product(left, _raised_form(right, Fraction(-1), "in a divisor"))


def value_of(form: Form, how: str) -> Expression:
    """Return the value of the form at the nominal point."""
    missing = form.open_names
    if missing:
        raise Impossible(f"not linear in the states: '{missing[0]}' stands {how}", _remedy(form, missing))
    return form.constant


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


def _raised_form(base: Form, exponent: Fraction, how: str) -> Form:
    """Return base ^ exponent: b^r + r b^(r−1) B."""
    value = value_of(base, how)
    if not base.linear or exponent == 0:
        return Form(raised(value, exponent))
    result = _there("value", lambda: raised(value, exponent))
    slope = _there("derivative", lambda: raised(value, exponent - 1))
    return Form(result, _scaled(base.linear, _times(Number(exponent), slope)), base.held)


def _there(what: str, found: Callable[[], Expression]) -> Expression:
    """Return the value or derivative of a function at the nominal point, if there is one."""
    try:
        return found()
    except Impossible as error:
        raise Impossible(
            f"there is no {what} at the nominal point: {error.message}",
            "linearise about a point where the expression is smooth",
        ) from None


def exponential(base: Form, exponent: Form) -> Form:
    """Return base ^ exponent: a power for a rational exponent, else exp(exponent·log(base))."""
    above = value_of(exponent, "in an exponent")
    if not isinstance(above, Number) or exponent.linear:
        value_of(base, "under a power")
        return applied("exp", product(exponent, applied("log", base)))
    return base if above.value == 1 else _raised_form(base, above.value, "under a power")


def applied(function: str, argument: Form) -> Form:
    """Return an elementary function of the form: f(a) + f'(a) A."""
    inner = value_of(argument, f"inside {function}")
    if not argument.linear:
        return Form(exact(Apply(function, inner)))
    value = _there("value", lambda: exact(Apply(function, inner)))
    slope = _there("derivative", lambda: _exactly(derivative_of(function, inner), inner))
    return Form(value, _scaled(argument.linear, slope), argument.held)


def exact(node: Expression) -> Expression:
    """Return a function or power with its exact value where there is one: cos(0) is 1."""
    if isinstance(node, Power):
        return raised(node.base, node.exponent)
    if not isinstance(node, Apply):
        return node
    known = apply_function(node.function, node.argument)
    if isinstance(known, str):
        raise Impossible(known)
    return node if known is None else known


def _exactly(root: Expression, inner: Expression) -> Expression:
    """Return the expression in ``inner`` with exact values."""
    done: dict[int, Expression] = {id(inner): inner}
    for node in postorder(root, known={id(inner)}):
        parts = children(node)
        settled = tuple(done[id(part)] for part in parts)
        is_same = all(one is other for one, other in zip(parts, settled, strict=True))
        done[id(node)] = exact(node if is_same else rebuild(node, settled))
    return done[id(root)]
