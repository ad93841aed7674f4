"""Field elements as exponential polynomials: sums of t^j e^{σt} cos νt and t^j e^{σt} sin νt.

An element is one exactly if the generators in it that vary are time, exponentials and half-angle tangents τ
of constant rates, its denominator is a constant times powers of e^{σt} and 1 + τ², and its degree in each τ
is at most that of the denominator: sin, cos of kθ are the Laurent polynomials in e^{iθ}, and in lowest
terms there is no other pole than e^{iθ} = 0, ∞.

References
----------
Morozov & Baklanov 2018, section 5.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Final, TypeAlias

from obscli.exact.field import Element
from obscli.exact.hidden_dynamics import is_constant, occurring
from obscli.exact.mode import Mode, harmonics, mode_product
from obscli.exact.polynomial import require_small
from obscli.model.expression import ONE, divide, symbols
from obscli.model.notation import to_text


if TYPE_CHECKING:
    from obscli.exact.field import Generator
    from obscli.exact.modes import Modes
    from obscli.exact.polynomial import Polynomial
    from obscli.exact.restore import Restorer
    from obscli.model.expression import Expression

#: Higher powers of the cosine of one angle are not written as sums.
_HIGHEST: Final = 400

#: A sum of modes, by their constant coefficients.
ExponentialPolynomial: TypeAlias = Mapping[Mode, Element]


class NotExponentialError(Exception):
    """An element that is no exponential polynomial; says why."""


class Expansion:
    """Writes elements of one field as sums of modes."""

    def __init__(self, modes: Modes, restorer: Restorer) -> None:
        self._modes, self._field, self._restorer = modes, modes.field, restorer

    def __call__(self, element: Element) -> dict[Mode, Element]:
        """Return an element as a sum of modes.

        Raises
        ------
        NotExponentialError : it is none
        UndecidedError : it has powers too high to be written as sums
        """
        self._require_known(element)
        below, halves, shifts = self._denominator(element)
        self._require_finite(element, halves)
        constant = Element(self._field, self._field.one_polynomial, below)
        total: dict[Mode, Element] = {}
        for (turns, powers, time), coefficient in self._grouped(element.num).items():
            exponents = tuple(a - b for a, b in zip(powers, shifts, strict=True))
            factor = Element(self._field, coefficient, self._field.one_polynomial) * constant
            for wave, multiple in self._waves(turns, halves).items():
                mode = wave._replace(exponents=exponents, power=time)
                term = factor * self._field.rational(multiple)
                total[mode] = total[mode] + term if mode in total else term
        return {mode: entry for mode, entry in total.items() if entry}

    def _denominator(self, element: Element) -> tuple[Polynomial, tuple[int, ...], tuple[int, ...]]:
        """Return the constant factor, the powers of 1 + τ² and those of exponentials."""
        rest, ctx = element.den, self._field.ctx
        halves, shifts = [], []
        for k in self._modes.angles:
            rest, count = _divided(rest, ctx.gen(k) ** 2 + 1)
            halves.append(count)
        for k in self._modes.exponentials:
            rest, count = _divided(rest, ctx.gen(k))
            shifts.append(count)
        if not is_constant(self._field, {0: Element(self._field, rest, self._field.one_polynomial)}):
            raise NotExponentialError(_none_of_them(divide(ONE, self._restorer.polynomial(rest))))
        return rest, tuple(halves), tuple(shifts)

    def _require_finite(self, element: Element, halves: tuple[int, ...]) -> None:
        """Refuse tan(θ/2) itself: a pole at θ = π."""
        degrees = element.num.degrees()
        for k, half in zip(self._modes.angles, halves, strict=True):
            if degrees[k] > 2 * half:
                raise NotExponentialError(_none_of_them(self._field.generators[k].meaning))
        require_small(max(halves, default=0), _HIGHEST)

    def _require_known(self, element: Element) -> None:
        """Refuse generators that vary and make no mode."""
        for k in sorted(occurring(element) & self._modes.others):
            raise NotExponentialError(self._of_generator(self._field.generators[k]))

    def _of_generator(self, generator: Generator) -> str:
        if generator.kind == "jet":
            return _left_open(generator.function)
        inside = generator.meaning if generator.argument is None else generator.argument
        named = symbols(inside, generator.meaning)
        for function in self._modes.exact.system.functions:
            if function.name in named:
                return _left_open(function.name) if function.derivative is None else _by_rule(function.name)
        if generator.kind in {"angle", "exponential"}:
            name = "sin, cos" if generator.kind == "angle" else "exp"
            return f"{name} of {to_text(inside)}, which does not grow at a constant rate"
        return _none_of_them(generator.meaning)

    def _grouped(
        self, polynomial: Polynomial
    ) -> dict[tuple[tuple[int, ...], tuple[int, ...], int], Polynomial]:
        """Return a polynomial by its powers of tangents, exponentials and time."""
        modes = self._modes
        varying = {*modes.angles, *modes.exponentials, modes.time}
        groups: dict[tuple[tuple[int, ...], tuple[int, ...], int], dict[tuple[int, ...], int]] = {}
        for exponents, coefficient in polynomial.terms():
            turns = tuple(int(exponents[k]) for k in modes.angles)
            powers = tuple(int(exponents[k]) for k in modes.exponentials)
            time = 0 if modes.time is None else int(exponents[modes.time])
            rest = tuple(0 if k in varying else int(e) for k, e in enumerate(exponents))
            groups.setdefault((turns, powers, time), {})[rest] = int(coefficient)
        return {key: self._field.ctx.from_dict(terms) for key, terms in groups.items()}

    def _waves(self, degrees: tuple[int, ...], halves: tuple[int, ...]) -> dict[Mode, Fraction]:
        """Return Π τ^i/(1 + τ²)^d as a sum of modes."""
        total = {self._modes.one: Fraction(1)}
        for place, (i, d) in enumerate(zip(degrees, halves, strict=True)):
            step: dict[Mode, Fraction] = {}
            for m, coefficient in harmonics(i, d).items():
                turns = tuple(2 * m if k == place else 0 for k in range(len(degrees)))
                wave = self._modes.one._replace(turns=turns, sine=bool(i % 2))
                for mode, value in total.items():
                    for product, factor in mode_product(mode, wave):
                        step[product] = step.get(product, Fraction(0)) + value * coefficient * factor
            total = {mode: value for mode, value in step.items() if value}
        return total


def _divided(polynomial: Polynomial, divisor: Polynomial) -> tuple[Polynomial, int]:
    """Return what is left of a polynomial without a factor, and how often it had it."""
    count = 0
    while True:
        quotient, rest = divmod(polynomial, divisor)
        if not rest.is_zero():
            return polynomial, count
        polynomial, count = quotient, count + 1


def _left_open(function: str) -> str:
    return f"{function} is a function left open"


def _by_rule(function: str) -> str:
    return f"{function} is a function given by its derivative, not as an expression in time"


def _none_of_them(function: Expression) -> str:
    return f"{to_text(function)} is no polynomial, exponential, sine or cosine of time, nor a product of them"
