"""The modes of one field: which angles and exponents are linear in time; rates, and back to expressions.

    (t^j)' = j t^{j−1},   (e^{σt})' = σ e^{σt},   (cos νt)' = −ν sin νt,   (sin νt)' = ν cos νt

Different modes are independent over the constants, as angles and exponentials of the field are
independent of each other and of time.
"""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Final

from obscli.exact.errors import JetOverflowError
from obscli.exact.hidden_dynamics import is_constant
from obscli.exact.mode import Mode
from obscli.model.expression import Apply, add, multiply, number, power


if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from obscli.exact.exact_system import ExactSystem
    from obscli.exact.field import Element
    from obscli.model.expression import Expression

_HALF: Final = Fraction(1, 2)


class Modes:
    """The generators that modes are made of, by index, and what derivation makes of modes.

    ``time``: None where time itself does not occur; ``angles``, ``exponentials``: those of constant rate;
    ``others``: whatever else varies, of which no mode is made.
    """

    def __init__(self, exact: ExactSystem) -> None:
        self.exact, self.field = exact, exact.field
        generators = self.field.generators
        varying = [k for k in range(len(generators)) if self._varies(k)]
        self.time = next((k for k in varying if generators[k].kind == "time"), None)
        self._rates = {k: rate for k in varying if (rate := self._constant_rate(k)) is not None}
        self.angles = [k for k in self._rates if generators[k].kind == "angle"]
        self.exponentials = [k for k in self._rates if generators[k].kind == "exponential"]
        self.others = frozenset(varying) - {self.time, *self._rates}
        self.one = Mode((0,) * len(self.angles), (0,) * len(self.exponentials), 0, sine=False)
        self._derivatives: dict[Mode, tuple[tuple[Mode, Element], ...]] = {}

    def _varies(self, k: int) -> bool:
        try:
            return self.field.varies(k)
        except JetOverflowError:
            return True

    def _constant_rate(self, k: int) -> Element | None:
        generator = self.field.generators[k]
        if generator.kind not in {"angle", "exponential"} or generator.argument is None:
            return None
        try:
            rate = self.field.derive(self.exact.interpreter.read(generator.argument))
            return rate if is_constant(self.field, {0: rate}) else None
        except JetOverflowError:
            return None

    def rate(self, mode: Mode) -> tuple[tuple[Mode, Element], ...]:
        """Return the derivative of a mode as a sum of modes."""
        known = self._derivatives.get(mode)
        if known is None:
            known = self._derivatives[mode] = tuple(self._rate(mode))
        return known

    def _rate(self, mode: Mode) -> Iterator[tuple[Mode, Element]]:
        if mode.power:
            yield mode._replace(power=mode.power - 1), self.field.rational(mode.power)
        growth = self._linear(self.exponentials, mode.exponents)
        if growth:
            yield mode, growth
        frequency = self._linear(self.angles, mode.turns) * self.field.rational(_HALF)
        if frequency:
            yield mode._replace(sine=not mode.sine), frequency if mode.sine else -frequency

    def _linear(self, generators: Sequence[int], multiples: Sequence[int]) -> Element:
        total = self.field.zero
        for k, multiple in zip(generators, multiples, strict=True):
            if multiple:
                total = total + self.field.rational(multiple) * self._rates[k]
        return total

    def expression(self, mode: Mode) -> Expression:
        """Return a mode as an expression."""
        factors = []
        if mode.power and self.time is not None:
            factors.append(power(self.field.generators[self.time].meaning, mode.power))
        if any(mode.exponents):
            factors.append(Apply("exp", self._argument(self.exponentials, mode.exponents, Fraction(1))))
        if any(mode.turns):
            argument = self._argument(self.angles, mode.turns, _HALF)
            factors.append(Apply("sin" if mode.sine else "cos", argument))
        return multiply(number(1), *factors)

    def _argument(self, generators: Sequence[int], multiples: Sequence[int], part: Fraction) -> Expression:
        terms = []
        for k, multiple in zip(generators, multiples, strict=True):
            argument = self.field.generators[k].argument
            if multiple and argument is not None:
                terms.append(multiply(number(multiple * part), argument))
        return add(*terms)

    def element(self, mode: Mode) -> Element:
        """Return a mode of whole base angles as an element."""
        result = self.field.one
        if mode.power and self.time is not None:
            result = self._generator(self.time) ** mode.power
        for k, exponent in zip(self.exponentials, mode.exponents, strict=True):
            result = result * self._generator(k) ** exponent
        cosine, sine = self.field.one, self.field.zero
        for k, turns in zip(self.angles, mode.turns, strict=True):
            c, s = self._cosine_sine(k)
            if turns < 0:
                s = -s
            for _ in range(abs(turns) // 2):
                cosine, sine = cosine * c - sine * s, cosine * s + sine * c
        return result * (sine if mode.sine else cosine)

    def _generator(self, k: int) -> Element:
        return self.field.generator(self.field.generators[k].name)

    def _cosine_sine(self, k: int) -> tuple[Element, Element]:
        one, tangent = self.field.one, self._generator(k)
        below = one + tangent * tangent
        return (one - tangent * tangent) / below, (tangent + tangent) / below
