"""Exponential polynomials: field elements as sums of t^j e^{σt} cos νt and t^j e^{σt} sin νt.

With τ = tan(θ/2), w = e^{iθ} and the coefficients of (w − 1)^i (w + 1)^{2d−i} = Σ_m c_m w^{m+d}:

    τ^i/(1 + τ²)^d = (−1)^{i/2} (c_0 + 2 Σ_{m>0} c_m cos mθ)/4^d          for even i
                   = (−1)^{(i−1)/2} 2 Σ_{m>0} c_m sin mθ/4^d              for odd i

An element is one exactly if its generators that vary are time, exponentials and half-angle tangents of
constant rates, its denominator is a constant times powers of e^{σt} and 1 + τ², and its degree in each τ is
at most that of the denominator. Such functions are independent over the constants.

References
----------
Morozov & Baklanov 2018, section 5.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from math import comb
from typing import TYPE_CHECKING, Final, NamedTuple, TypeAlias

from obscli.exact.field import Element
from obscli.exact.hidden_dynamics import is_constant, occurring
from obscli.exact.polynomial import require_small
from obscli.model.expression import Apply, add, multiply, number, power
from obscli.model.notation import to_text


if TYPE_CHECKING:
    from fractions import Fraction

    from obscli.exact.exact_system import ExactSystem
    from obscli.exact.polynomial import Polynomial
    from obscli.exact.restore import Restorer
    from obscli.model.expression import Expression

#: Harmonics beyond this are not written out.
_HIGHEST: Final = 400


class Mode(NamedTuple):
    """The function t^power e^{σt} cos νt, or with sin νt.

    ``turns``: ν in halves of the base angles, first entry that is not zero > 0; ``exponents``: σ in the base
    exponents.
    """

    turns: tuple[int, ...]
    exponents: tuple[int, ...]
    power: int
    sine: bool

    @property
    def rank(self) -> tuple[object, ...]:
        """Where it stands among others: 1 first, slow before fast, cosine before sine."""
        size = sum(map(abs, self.turns)), sum(map(abs, self.exponents))
        return (*size, self.turns, self.exponents, self.power, self.sine)


#: A sum of modes, by their constant coefficients.
ExponentialPolynomial: TypeAlias = Mapping[Mode, Element]


class NotExponentialError(Exception):
    """An element that is no exponential polynomial; says why."""


class Modes:
    """The exponential polynomials of one field: expanded, differentiated, written."""

    def __init__(self, exact: ExactSystem, restorer: Restorer) -> None:
        self.exact, self.field, self._restorer = exact, exact.field, restorer
        varying = [k for k in range(len(self.field.generators)) if self.field.varies(k)]
        kinds = {k: self.field.generators[k].kind for k in varying}
        self._time = next((k for k in varying if kinds[k] == "time"), None)
        self._rates = {
            k: rate
            for k in varying
            if kinds[k] in {"angle", "exponential"} and (rate := self._constant_rate(k)) is not None
        }
        self.angles = [k for k in self._rates if kinds[k] == "angle"]
        self.exponentials = [k for k in self._rates if kinds[k] == "exponential"]
        self._others = [k for k in varying if k != self._time and k not in self._rates]
        self.one = self._mode()
        self._derivatives: dict[Mode, list[tuple[Mode, Element]]] = {}

    def _constant_rate(self, k: int) -> Element | None:
        argument = self.field.generators[k].argument
        assert argument is not None
        rate = self.field.derive(self.exact.interpreter.read(argument))
        return rate if is_constant(self.field, {0: rate}) else None

    def _mode(self) -> Mode:
        return Mode((0,) * len(self.angles), (0,) * len(self.exponentials), 0, False)  # noqa: FBT003

    # -- from elements

    def expand(self, element: Element) -> dict[Mode, Element]:
        """Return an element as a sum of modes.

        Raises
        ------
        NotExponentialError : it is none
        """
        below, halves, shifts = self._denominator(element)
        self._require_modes(element, halves)
        constant = Element(self.field, self.field.one_polynomial, below)
        total: dict[Mode, Element] = {}
        for exponents, coefficient in self._grouped(element.num).items():
            turns, powers, time = exponents
            shifted = tuple(a - b for a, b in zip(powers, shifts, strict=True))
            factor = self.field.fraction(coefficient, self.field.one_polynomial) * constant
            for mode, multiple in self._tangents(turns, halves).items():
                _add(total, mode._replace(exponents=shifted, power=time), factor * self._rational(multiple))
        return total

    def _denominator(self, element: Element) -> tuple[Polynomial, tuple[int, ...], tuple[int, ...]]:
        """Return the constant factor, the powers of 1 + τ² and those of exponentials."""
        rest, ctx = element.den, self.field.ctx
        halves, shifts = [], []
        for k in self.angles:
            rest, count = _divided(rest, ctx.gen(k) ** 2 + 1)
            halves.append(count)
        for k in self.exponentials:
            rest, count = _divided(rest, ctx.gen(k))
            shifts.append(count)
        if not is_constant(self.field, {0: Element(self.field, rest, self.field.one_polynomial)}):
            self._name_other(element)
            raise NotExponentialError(_none_of_them(self._reciprocal(rest)))
        return rest, tuple(halves), tuple(shifts)

    def _reciprocal(self, polynomial: Polynomial) -> str:
        written = to_text(self._restorer.polynomial(polynomial))
        return f"1/{written}" if written.isidentifier() else f"1/({written})"

    def _require_modes(self, element: Element, halves: tuple[int, ...]) -> None:
        self._name_other(element)
        degrees = element.num.degrees()
        if any(degrees[k] > 2 * half for k, half in zip(self.angles, halves, strict=True)):
            raise NotExponentialError(_none_of_them(to_text(self._restorer.element(element))))
        require_small(max(halves, default=0), _HIGHEST)

    def _name_other(self, element: Element) -> None:
        """Raise with the first generator of an element that makes no mode."""
        for k in sorted(occurring(element) & set(self._others)):
            generator = self.field.generators[k]
            if generator.kind == "jet":
                raise NotExponentialError(f"{generator.function} is a function left open")
            if generator.kind == "function":
                reason = "is a function with a rule of its own, which is not looked into"
                raise NotExponentialError(f"{generator.name} {reason}")
            if generator.argument is not None and generator.kind in {"angle", "exponential"}:
                name = "sin, cos" if generator.kind == "angle" else "exp"
                text = to_text(generator.argument)
                raise NotExponentialError(f"{name} of {text}: the rate of {text} is not constant")
            raise NotExponentialError(_none_of_them(to_text(generator.meaning)))

    def _grouped(
        self, polynomial: Polynomial
    ) -> dict[tuple[tuple[int, ...], tuple[int, ...], int], Polynomial]:
        """Return a polynomial by the exponents of its varying generators."""
        groups: dict[tuple[tuple[int, ...], tuple[int, ...], int], dict[tuple[int, ...], int]] = {}
        for exponents, coefficient in polynomial.terms():
            turns = tuple(int(exponents[k]) for k in self.angles)
            powers = tuple(int(exponents[k]) for k in self.exponentials)
            time = 0 if self._time is None else int(exponents[self._time])
            rest = list(exponents)
            for k in (*self.angles, *self.exponentials):
                rest[k] = 0
            if self._time is not None:
                rest[self._time] = 0
            groups.setdefault((turns, powers, time), {})[tuple(rest)] = coefficient
        return {key: self.field.ctx.from_dict(terms) for key, terms in groups.items()}

    def _tangents(self, degrees: tuple[int, ...], halves: tuple[int, ...]) -> dict[Mode, Fraction]:
        """Return Π τ^i/(1 + τ²)^d as a sum of modes."""
        total: dict[Mode, Fraction] = {self.one: number(1).value}
        for place, (i, d) in enumerate(zip(degrees, halves, strict=True)):
            step: dict[Mode, Fraction] = {}
            for m, coefficient in _harmonics(i, d).items():
                turns = tuple(2 * m if k == place else 0 for k in range(len(self.angles)))
                wave = self.one._replace(turns=turns, sine=bool(i % 2))
                for mode, value in total.items():
                    for product, factor in mode_product(mode, wave):
                        step[product] = step.get(product, number(0).value) + value * coefficient * factor
            total = {mode: value for mode, value in step.items() if value}
        return total

    def _rational(self, value: Fraction) -> Element:
        return self.field.rational(value)

    # -- the derivation

    def rate(self, mode: Mode) -> list[tuple[Mode, Element]]:
        """Return the derivative of a mode: j t^{j−1} …, σ …, and ∓ν times its partner."""
        known = self._derivatives.get(mode)
        if known is None:
            known = self._derivatives[mode] = list(self._rate(mode))
        return known

    def _rate(self, mode: Mode) -> list[tuple[Mode, Element]]:
        field, found = self.field, []
        if mode.power:
            found.append((mode._replace(power=mode.power - 1), field.rational(mode.power)))
        growth = self._linear(self.exponentials, mode.exponents)
        if growth:
            found.append((mode, growth))
        frequency = self._linear(self.angles, mode.turns) * field.rational(number(1).value / 2)
        if frequency:
            found.append((mode._replace(sine=not mode.sine), frequency if mode.sine else -frequency))
        return found

    def _linear(self, generators: list[int], multiples: tuple[int, ...]) -> Element:
        total = self.field.zero
        for k, multiple in zip(generators, multiples, strict=True):
            if multiple:
                total = total + self.field.rational(multiple) * self._rates[k]
        return total

    # -- back

    def expression(self, mode: Mode) -> Expression:
        """Return a mode as an expression."""
        factors = []
        if mode.power:
            assert self._time is not None
            factors.append(power(self.field.generators[self._time].meaning, mode.power))
        if any(mode.exponents):
            factors.append(Apply("exp", self._argument(self.exponentials, mode.exponents, 1)))
        if any(mode.turns):
            name = "sin" if mode.sine else "cos"
            factors.append(Apply(name, self._argument(self.angles, mode.turns, 2)))
        return multiply(number(1), *factors)

    def _argument(self, generators: list[int], multiples: tuple[int, ...], parts: int) -> Expression:
        terms = []
        for k, multiple in zip(generators, multiples, strict=True):
            argument = self.field.generators[k].argument
            if multiple and argument is not None:
                terms.append(multiply(number(number(multiple).value / parts), argument))
        return add(*terms)

    def element(self, mode: Mode) -> Element:
        """Return a mode of whole base angles as an element."""
        field = self.field
        result = field.one
        if mode.power:
            assert self._time is not None
            result = field.generator(field.generators[self._time].name) ** mode.power
        for k, exponent in zip(self.exponentials, mode.exponents, strict=True):
            result = result * field.generator(field.generators[k].name) ** exponent
        cosine, sine = field.one, field.zero
        for k, half_turns in zip(self.angles, mode.turns, strict=True):
            c, s = self._base(k)
            if half_turns < 0:
                s = -s
            for _ in range(abs(half_turns) // 2):
                cosine, sine = cosine * c - sine * s, cosine * s + sine * c
        return result * (sine if mode.sine else cosine)

    def _base(self, k: int) -> tuple[Element, Element]:
        field = self.field
        tangent = field.generator(field.generators[k].name)
        below = field.one + tangent * tangent
        return (field.one - tangent * tangent) / below, (tangent + tangent) / below


def mode_product(a: Mode, b: Mode) -> list[tuple[Mode, Fraction]]:
    """Return the product of two modes, by the addition theorems."""
    return _mode_product(a, b)


@cache
def _mode_product(a: Mode, b: Mode) -> list[tuple[Mode, Fraction]]:
    half = number(1).value / 2
    exponents = tuple(x + y for x, y in zip(a.exponents, b.exponents, strict=True))
    power_ = a.power + b.power
    up = tuple(x + y for x, y in zip(a.turns, b.turns, strict=True))
    down = tuple(x - y for x, y in zip(a.turns, b.turns, strict=True))
    sine = a.sine != b.sine
    signs = {(False, False): (1, 1), (True, True): (-1, 1), (True, False): (1, 1), (False, True): (1, -1)}
    found: dict[Mode, Fraction] = {}
    for turns, sign in zip((up, down), signs[a.sine, b.sine], strict=True):
        lead = next((turn for turn in turns if turn), 0)
        if sine and not lead:
            continue
        flip = -1 if lead < 0 else 1
        mode = Mode(tuple(flip * turn for turn in turns), exponents, power_, sine)
        value = half * sign * (flip if sine else 1)
        found[mode] = found.get(mode, 0 * half) + value
    return [(mode, value) for mode, value in found.items() if value]


@cache
def _harmonics(i: int, d: int) -> dict[int, Fraction]:
    """Return τ^i/(1 + τ²)^d by multiples of θ: of cosines for even i, of sines for odd i."""
    quarter = number(1).value / 4**d
    sign = -1 if i // 2 % 2 else 1
    found = {}
    for m in range(d + 1):
        coefficient = sum(
            (-1) ** (i - k) * comb(i, k) * comb(2 * d - i, m + d - k)
            for k in range(max(0, m + i - d), min(i, m + d) + 1)
        )
        if coefficient:
            found[m] = quarter * sign * coefficient * (2 if m else 1)
    return found


def _divided(polynomial: Polynomial, divisor: Polynomial) -> tuple[Polynomial, int]:
    """Return what is left of a polynomial without a factor, and how often it had it."""
    count = 0
    while True:
        quotient, rest = divmod(polynomial, divisor)
        if not rest.is_zero():
            return polynomial, count
        polynomial, count = quotient, count + 1


def _add(total: dict[Mode, Element], mode: Mode, term: Element) -> None:
    result = total[mode] + term if mode in total else term
    if result:
        total[mode] = result
    else:
        total.pop(mode, None)


def _none_of_them(text: str) -> str:
    return f"{text} is no polynomial, exponential, sine or cosine of time, nor a product of them"
