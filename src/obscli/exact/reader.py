"""What the functions that read sines, roots and logarithms may ask of the interpreter they serve."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Protocol


if TYPE_CHECKING:
    from obscli.exact.field import Element, Field
    from obscli.exact.polynomial import Polynomial
    from obscli.model.expression import Expression


class Reader(Protocol):
    """The interpreter, as ``angles``, ``roots`` and ``primitives`` see it.

    ``fineness``: the step in which each angle, exponent or root is taken, by name of its atom.
    ``kept_apart``: atoms with multiples too far apart for one step, related though the field does not know.
    ``logarithms``: name and argument of each logarithm in the field so far.
    """

    field: Field
    fineness: dict[str, Fraction]
    kept_apart: set[str]
    logarithms: list[tuple[str, Element]]

    def read(self, node: Expression) -> Element:
        """Return the element that an expression stands for."""
        ...

    def power(self, base: Element, exponent: Fraction) -> Element:
        """Return a rational power of an element."""
        ...

    def exponential(self, argument: Element) -> Element:
        """Return exp of an element."""
        ...

    def constant_pi(self) -> Element:
        """Return π."""
        ...

    def expression(self, polynomial: Polynomial) -> Expression:
        """Return a polynomial as an expression."""
        ...

    def element_expression(self, element: Element) -> Expression:
        """Return an element as an expression."""
        ...

    def is_numeric(self, element: Element) -> bool:
        """Whether an element is a number."""
        ...
