"""Expressions evaluated in floating point, a whole batch of instants at once.

The second interpreter of the model's expressions; it shares nothing with the exact one. Every distinct node
is evaluated once a batch: a number stays a float, what varies in time is an array of shape (k,).
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from itertools import accumulate
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from obscli.model.constants import apply_function
from obscli.model.expression import (
    Apply,
    Derivative,
    Expression,
    Number,
    Pi,
    Power,
    Product,
    Sum,
    Symbol,
    children,
    postorder,
)


Array: TypeAlias = NDArray[np.float64]
Flags: TypeAlias = NDArray[np.bool_]
Counts: TypeAlias = NDArray[np.intp]

#: The spacing of doubles around 1.
EPS: Final = float(np.finfo(np.float64).eps)

#: The standard deviation of one rounding, relative.
ROUNDING: Final = EPS / 4

#: Arguments at which a function may have an exact value: cos(pi/2) is 0, not 6e-17.
_CONSTANT: Final = (Number, Pi, Product)

#: A constant, or the values at the instants of a batch.
Value: TypeAlias = float | Array

FUNCTIONS: Final[Mapping[str, Callable[[Value], Value]]] = {
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan,
    "exp": np.exp, "log": np.log, "sinh": np.sinh, "cosh": np.cosh, "tanh": np.tanh,
    "asinh": np.arcsinh, "acosh": np.arccosh, "atanh": np.arctanh,
}  # fmt: skip


#: df/du by the function's argument u and value f.
SLOPES: Final[Mapping[str, Callable[[Value, Value], Value]]] = {
    "sin": lambda u, _: np.cos(u),
    "cos": lambda u, _: np.sin(u),
    "tan": lambda _, f: 1 + f * f,
    "asin": lambda u, _: 1 / np.sqrt(1 - u * u),
    "acos": lambda u, _: 1 / np.sqrt(1 - u * u),
    "atan": lambda u, _: 1 / (1 + u * u),
    "exp": lambda _, f: f,
    "log": lambda u, _: np.reciprocal(u),
    "sinh": lambda u, _: np.cosh(u),
    "cosh": lambda u, _: np.sinh(u),
    "tanh": lambda _, f: 1 - f * f,
    "asinh": lambda u, _: 1 / np.sqrt(u * u + 1),
    "acosh": lambda u, _: 1 / np.sqrt(u * u - 1),
    "atanh": lambda u, _: np.reciprocal(1 - u * u),
}


@dataclass(frozen=True, slots=True, eq=False)
class Rounded:
    """A value and the standard deviation that rounding gives it."""

    value: Value
    error: Value


class Program:
    """Some expressions in the order in which they are evaluated together.

    Parameters
    ----------
    roots : the expressions wanted
    """

    def __init__(self, roots: Sequence[Expression]) -> None:
        self._nodes = tuple(postorder(*roots))
        self._roots = tuple(roots)

    def run(self, values: Mapping[str, Value]) -> list[Value]:
        """Return the value of every root; outside its domain a value is not a number.

        Parameters
        ----------
        values : by name: the time, parameters, functions (``f``) and their derivatives (``f'``)
        """
        memo: dict[int, Value] = {}
        with np.errstate(all="ignore"):
            for node in self._nodes:
                memo[id(node)] = _value(node, [memo[id(part)] for part in children(node)], values)
        return [memo[id(root)] for root in self._roots]

    def run_rounded(self, values: Mapping[str, Value], errors: Mapping[str, Value]) -> list[Rounded]:
        """Return every root with its rounding error: 10⁶ − 10⁶ is 0, but not to 16 digits.

        Every operation adds a random error of ``ROUNDING`` times its result, sums one with every term, and
        passes on those of its arguments by its derivative.

        Parameters
        ----------
        values : as for ``run``
        errors : the errors of the values, by name; absent: exact
        """
        memo: dict[int, Rounded] = {}
        with np.errstate(all="ignore"):
            for node in self._nodes:
                parts = [memo[id(part)] for part in children(node)]
                value = _value(node, [part.value for part in parts], values)
                memo[id(node)] = Rounded(value, np.sqrt(_squared_error(node, value, parts, errors)))
        return [memo[id(root)] for root in self._roots]


def _value(node: Expression, parts: Sequence[Value], values: Mapping[str, Value]) -> Value:
    match node:
        case Number(value):
            return _nearest(value)
        case Pi():
            return math.pi
        case Symbol(name):
            return values[name]
        case Derivative(name, order):
            return values[jet(name, order)]
        case Sum():
            return reduce(operator.add, parts)
        case Product():
            return reduce(operator.mul, parts)
        case Power(_, exponent):
            return _power(parts[0], exponent)
        case Apply(function):
            exact = _exact(node)
            return FUNCTIONS[function](parts[0]) if exact is None else _nearest(exact)


def _exact(node: Expression) -> Fraction | None:
    """Return the rational value of numbers, and of functions where it is known."""
    value = (
        apply_function(node.function, node.argument)
        if isinstance(node, Apply) and isinstance(node.argument, _CONSTANT)
        else node
    )
    return value.value if isinstance(value, Number) else None


def _power(base: Value, exponent: Fraction) -> Value:
    if exponent == 2:
        return base * base
    if exponent == Fraction(1, 2):
        return np.sqrt(base)
    return np.power(base, _nearest(exponent))


def _nearest(value: Fraction) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def _squared_error(
    node: Expression, value: Value, parts: Sequence[Rounded], errors: Mapping[str, Value]
) -> Value:
    exact = _exact(node)
    if exact is not None:
        return 0.0 if value == exact else _square(ROUNDING * value)
    match node:
        case Symbol(name):
            return _square(errors.get(name, 0.0))
        case Derivative(name, order):
            return _square(errors.get(jet(name, order), 0.0))
        case Sum():
            partial = accumulate(part.value for part in parts)
            next(partial)
            return sum((_square(ROUNDING * one) for one in partial), sum(_square(p.error) for p in parts))
        case Product():
            passed = [
                reduce(operator.mul, [other.value for other in (*parts[:k], *parts[k + 1 :])], part.error)
                for k, part in enumerate(parts)
            ]
        case Power(_, exponent):
            u = parts[0]
            passed = [_passed_on(_nearest(exponent) * _power(u.value, exponent - 1), u.error)]
        case Apply(function):
            u = parts[0]
            passed = [_passed_on(SLOPES[function](u.value, value), u.error)]
        case _:  # pi
            passed = []
    return sum(map(_square, passed), _square(ROUNDING * value))


def _square(x: Value) -> Value:
    """Return x², infinite where it is too large: ``x ** 2`` raises for a float."""
    return x * x


def _passed_on(slope: Value, error: Value) -> Value:
    """Return slope times error; an argument without error has none to pass on where the slope is infinite."""
    return np.where(np.equal(error, 0.0), 0.0, slope * error)


def jet(name: str, order: int) -> str:
    """Return the name under which the derivative of a function is looked up: f, f', f''."""
    return name + "'" * order


def constant_value(expression: Expression, values: Mapping[str, Value]) -> float:
    """Return the value of an expression free of time."""
    return float(Program([expression]).run(values)[0])


def constant_error(expression: Expression) -> float:
    """Return the rounding error of the value of an expression without symbols."""
    return float(Program([expression]).run_rounded({}, {})[0].error)
