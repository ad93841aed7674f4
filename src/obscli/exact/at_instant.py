"""Elements of a field of functions of time at one instant: elements of a field of constants.

Every generator is a known expression in time, so its value at t0 is that expression with t0 in place of t,
read anew: tan(ωt/2) is 0 at t = 0. Functions without a formula stand for their values at t0.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from obscli.exact.interpreter import Interpreter
from obscli.model.expression import TimeDerivative, substitute


if TYPE_CHECKING:
    from obscli.exact.exact_system import ExactSystem, Row
    from obscli.exact.field import Element
    from obscli.exact.polynomial import Polynomial
    from obscli.model.expression import Expression


class AtInstant:
    """Takes elements of the field of a system at one instant.

    Parameters
    ----------
    exact : the system
    instant : t0, free of time

    Raises
    ------
    UndefinedError : a generator has no value at t0
    UndecidedError : zero cannot be decided for one
    """

    def __init__(self, exact: ExactSystem, instant: Expression) -> None:
        system, known = exact.system, exact.interpreter
        derive = TimeDerivative(system.time, known.rules, frozenset())
        values = {system.time: instant}
        meanings = [substitute(g.meaning, values, derive) for g in exact.field.generators]
        self.interpreter = Interpreter(system, meanings, known.jets)
        self.field = self.interpreter.field
        self._images = [self.interpreter.read(meaning) for meaning in meanings]

    def row(self, row: Row) -> dict[int, Element]:
        """Return a row at the instant, without zeros.

        Raises
        ------
        UndefinedError : an entry does not exist there
        """
        values = {j: self.element(entry) for j, entry in row.items()}
        return {j: value for j, value in values.items() if value}

    def element(self, element: Element) -> Element:
        """Return one element at the instant."""
        return self._polynomial(element.num) / self._polynomial(element.den)

    def _polynomial(self, polynomial: Polynomial) -> Element:
        total = self.field.zero
        for exponents, coefficient in polynomial.terms():
            term = self.field.rational(int(coefficient))
            for image, exponent in zip(self._images, exponents, strict=False):
                if exponent and term:
                    term = term * image ** int(exponent)
            total = total + term
        return total
