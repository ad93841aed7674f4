"""Real evaluation in ball arithmetic: rigorous power series of expressions at a rational point.

Nothing here knows the differential field: expressions are evaluated as they stand in the model, as
truncated Taylor series in t - t0 with ball coefficients (Arb). A nonzero number found here is nonzero
whatever generators secretly depend on each other.
"""

from __future__ import annotations

import random
from contextlib import contextmanager
from fractions import Fraction
from typing import TYPE_CHECKING

import flint
from flint import arb, arb_series, fmpq

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
)


if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from obscli.model.system import System


class OutsideDomainError(Exception):
    """A coefficient does not exist (or is not seen to exist) as a real number at this point."""


@contextmanager
def precision(bits: int, length: int) -> Iterator[None]:
    """Work with balls of this precision and series of this many terms; restore the former setting."""
    saved = flint.ctx.prec, flint.ctx.cap
    flint.ctx.prec, flint.ctx.cap = bits, length
    try:
        yield
    finally:
        flint.ctx.prec, flint.ctx.cap = saved


def without_value(name: str, systems: Iterable[System]) -> str:
    """Return why a name has no value that balls could be made of."""
    systems = tuple(systems)
    if any(name in system.sampled for system in systems):
        return f"{name} is given by samples, and a proof at the file's values needs an expression"
    if any(name == one.name for system in systems for one in system.functions):
        return f"{name} is left open, and a proof at the file's values needs an expression"
    return f"{name} has no value (--set)"


class BallPoint:
    """Series of the expressions of a system at one rational point; use inside ``precision``.

    Parameters
    ----------
    system : names and rules
    values : exact value by name: time, parameters, and jets of functions (``f``, ``f'``, ``f''``, …)
    length : number of series terms
    definitions : functions given by a relation as expressions of the others
    """

    def __init__(
        self,
        system: System,
        values: Mapping[str, Fraction],
        length: int,
        definitions: Mapping[str, Expression] | None = None,
    ) -> None:
        self._system = system
        self._values = values
        self._length = length
        self._memo: dict[int, tuple[Expression, arb_series]] = {}
        self._functions: dict[str, arb_series] = {}
        self._definitions = dict(definitions or {})
        self._integrate()

    def value(self, node: Expression) -> arb_series:
        """Return the series of an expression.

        Raises
        ------
        OutsideDomainError : a denominator, logarithm or root cannot be evaluated at the point
        """
        known = self._memo.get(id(node))
        if known is None:
            series = self._value(node)
            if not all(ball.is_finite() for ball in series.coeffs()):
                raise OutsideDomainError
            known = self._memo[id(node)] = (node, series)
        return known[1]

    def _value(self, node: Expression) -> arb_series:
        match node:
            case Number(value):
                return self._constant(_ball(value))
            case Pi():
                return self._constant(arb.pi())
            case Symbol(name):
                return self._symbol(name)
            case Derivative(name, order):
                series = self._symbol(name)
                for _ in range(order):
                    series = series.derivative()
                return series
            case Sum(terms):
                return sum((self.value(term) for term in terms[1:]), self.value(terms[0]))
            case Product(factors):
                result = self.value(factors[0])
                for factor in factors[1:]:
                    result = result * self.value(factor)
                return result
            case Power(base, exponent):
                return self._power(self.value(base), exponent)
        return self._apply(node)

    def _constant(self, ball: arb) -> arb_series:
        return arb_series([ball])

    def _symbol(self, name: str) -> arb_series:
        if name in self._functions:
            return self._functions[name]
        if name == self._system.time:
            return arb_series([_ball(self._values[name]), 1])
        return self._constant(_ball(self._values[name]))

    def _power(self, base: arb_series, exponent: Fraction) -> arb_series:
        if exponent.denominator == 1:
            return _integer_power(base, exponent.numerator)
        if not base[0] > 0:
            raise OutsideDomainError
        if exponent.denominator == 2:
            return _integer_power(base.sqrt(), exponent.numerator)
        return (base.log() * self._constant(_ball(exponent))).exp()

    def _apply(self, node: Apply) -> arb_series:
        u = self.value(node.argument)
        match node.function:
            case "log":
                return self._log(u)
            case "sinh" | "cosh" | "tanh":
                up, down = u.exp(), (-u).exp()
                top = up + down if node.function == "cosh" else up - down
                return top / (up + down) if node.function == "tanh" else top / 2
            case "asinh":
                return self._log(u + (u * u + 1).sqrt())
            case "acosh":
                return self._log(u + self._power(u * u - 1, Fraction(1, 2)))
            case "atanh":
                return self._log((1 + u) / (1 - u)) / 2
        result: arb_series = getattr(u, node.function)()
        return result

    def _log(self, u: arb_series) -> arb_series:
        if not u[0] > 0:
            raise OutsideDomainError
        return u.log()

    def _integrate(self) -> None:
        """Set up the series of the functions: given jets, or rules f' = F solved term by term."""
        ruled = {}
        for f in self._system.functions:
            if f.name in self._definitions:
                continue
            if f.derivative is not None and f.name in self._values:
                ruled[f.name] = f.derivative
                self._functions[f.name] = self._constant(_ball(self._values[f.name]))
            elif f.name in self._values:
                self._functions[f.name] = arb_series(self._taylor(f.name))
        for length in range(1, self._length if ruled else 1):
            with precision(flint.ctx.prec, length):
                self._resolve()
                rates = {name: self.value(rule)[length - 1] for name, rule in ruled.items()}
            for name, rate in rates.items():
                coefficients = [self._functions[name][k] for k in range(length)]
                self._functions[name] = arb_series([*coefficients, rate / length])
        self._resolve()

    def _resolve(self) -> None:
        self._memo.clear()
        for name, definition in self._definitions.items():
            self._functions.pop(name, None)
            self._functions[name] = self.value(definition)

    def _taylor(self, name: str) -> list[arb]:
        coefficients, factorial, key = [], 1, name
        for order in range(self._length):
            factorial *= max(order, 1)
            coefficients.append(_ball(self._values.get(key, Fraction(0))) / factorial)
            key += "'"
        return coefficients


def _ball(value: Fraction) -> arb:
    return arb(fmpq(value.numerator, value.denominator))


def _integer_power(base: arb_series, exponent: int) -> arb_series:
    if exponent < 0:
        if base[0].contains(0):
            raise OutsideDomainError
        return _integer_power(base.inv(), -exponent)
    result = arb_series([1])
    while exponent:
        if exponent & 1:
            result = result * base
        exponent >>= 1
        if exponent:
            base = base * base
    return result


def random_point(system: System, names: frozenset[str], jets: int, seed: int) -> dict[str, Fraction]:
    """Return a small rational value for time, every parameter and every jet (up to ``jets``) in use."""
    source = random.Random(seed)  # noqa: S311  (a random point, no secret)
    point: dict[str, Fraction] = {}
    if system.time in names:
        point[system.time] = Fraction(source.randrange(5, 40), 23)
    for parameter in system.parameters:
        if parameter.name in names:
            sign = 1 if parameter.assume == "positive" or source.random() < 0.75 else -1
            point[parameter.name] = sign * Fraction(source.randrange(5, 40), 19)
    for f in system.functions:
        if f.name in names:
            orders = 1 if f.derivative is not None else jets + 1
            for order in range(orders):
                point[f.name + "'" * order] = Fraction(source.randrange(-40, 41), 37)
    return point
