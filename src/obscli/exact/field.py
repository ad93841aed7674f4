"""The differential field: generators, relations, derivation, and elements as fractions of polynomials.

Level: polynomials over Z in named generators (FLINT), reduced modulo monic relations of algebraic
generators. This file knows arithmetic and the derivation; which generators there are and what they mean
is decided in ``adjunction``. Zero-equivalence is decided by normal form: an element is zero iff its
reduced numerator is.

    (p/q)' = (p'q - pq')/q²,   p' = Σ_i ∂p/∂g_i · g_i'
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce as fold
from typing import TYPE_CHECKING, Literal, TypeAlias

from flint import Ordering, fmpz_mpoly_ctx

from obscli.exact.errors import UndecidedError, UndefinedError
from obscli.exact.polynomial import MOST_PAIRS, MOST_TERMS, common_factor, require_small, times


if TYPE_CHECKING:
    from obscli.exact.polynomial import Polynomial
    from obscli.model.expression import Expression

#: Norms of polynomials with a larger product of degrees and terms are not computed.
_LARGEST_NORM = 5000
_LARGEST_DEGREE = 100_000

Kind: TypeAlias = Literal[
    "time", "parameter", "jet", "function", "angle", "exponential", "primitive", "root", "pi"
]


_WRITING_ORDER: tuple[Kind, ...] = (
    "pi", "parameter", "root", "jet", "function", "time", "exponential", "primitive", "angle",
)  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Generator:
    """One generator of the field.

    ``meaning`` is its value as an expression. ``argument``: the base angle θ of τ = tan(θ/2), the exponent
    u of exp(u), the argument of a primitive (log, atan, asin), the radicand of a root. ``function`` names
    the primitive; for a jet the function differentiated ``order`` times. A root satisfies
    g^order = Σ relation_k g^k. ``positive`` says that its real value is known to be positive.
    """

    name: str
    kind: Kind
    meaning: Expression
    argument: Expression | None = None
    function: str = ""
    order: int = 0
    relation: tuple[Expression, ...] = ()
    positive: bool = False
    numeric: bool = False

    @property
    def writing_order(self) -> int:
        """The place of its kind in a product: numbers, parameters, functions, time, exponentials, angles."""
        return _WRITING_ORDER.index(self.kind)


class Element:
    """A fraction of two polynomials in the generators of a field, in lowest terms."""

    __slots__ = ("den", "field", "num")

    def __init__(self, field: Field, num: Polynomial, den: Polynomial) -> None:
        self.field = field
        self.num = num
        self.den = den

    def __bool__(self) -> bool:
        return not self.num.is_zero()

    def __add__(self, other: Element) -> Element:
        if not self.num:
            return other
        if not other.num:
            return self
        if self.den == other.den:
            return self.field.fraction(self.num + other.num, self.den)
        common = common_factor(self.den, other.den)
        mine, others = self.den / common, other.den / common
        return self.field.fraction(times(self.num, others) + times(other.num, mine), times(self.den, others))

    def __neg__(self) -> Element:
        return Element(self.field, -self.num, self.den)

    def __sub__(self, other: Element) -> Element:
        return self + (-other)

    def __mul__(self, other: Element) -> Element:
        return self.field.fraction(times(self.num, other.num), times(self.den, other.den))

    def __truediv__(self, other: Element) -> Element:
        if not other.num:
            raise UndefinedError
        return self.field.fraction(times(self.num, other.den), times(self.den, other.num))

    def __pow__(self, exponent: int) -> Element:
        if exponent < 0:
            return self.field.one / self ** (-exponent)
        size = max(len(self.num), len(self.den))
        if size > 1 and exponent * size > 50_000:
            raise UndecidedError(f"a power with exponent {exponent} is too large for exact algebra")
        degree = max(0, *self.num.degrees(), *self.den.degrees())
        require_small(exponent * degree, _LARGEST_DEGREE)
        result, square = self.field.one, self
        while exponent:
            if exponent & 1:
                result = result * square
            exponent >>= 1
            if exponent:
                square = square * square
        return result

    @property
    def rational(self) -> Fraction | None:
        """The element as a rational number, None where it is none."""
        if not (self.num.is_constant() and self.den.is_constant()):
            return None
        return Fraction(int(self.num.leading_coefficient()), int(self.den.leading_coefficient()))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Element):
            return NotImplemented
        return not (self - other)

    __hash__ = None  # type: ignore[assignment]


class Field:
    """The polynomial ring behind the field, its relations, and the derivation d/dt.

    Roots come first in a lexicographic order, the last adjoined in front, so that division by a relation
    g^d - … lowers the degree in g and brings in earlier generators only.
    """

    def __init__(self, generators: Sequence[Generator], derivation: Callable[[Generator], Element]) -> None:
        roots = [g for g in generators if g.kind == "root"]
        rest = [g for g in generators if g.kind != "root"]
        self.generators: tuple[Generator, ...] = (*reversed(roots), *rest)
        self.ctx = fmpz_mpoly_ctx.get([f"v{k}" for k in range(max(1, len(self.generators)))], Ordering.lex)
        self.index = {g.name: k for k, g in enumerate(self.generators)}
        self.one_polynomial = self.ctx.constant(1)
        self.zero = Element(self, self.ctx.constant(0), self.one_polynomial)
        self.one = Element(self, self.one_polynomial, self.one_polynomial)
        self._relations: list[tuple[int, Polynomial]] = []
        self._derivation = derivation
        self._derivatives: dict[int, Element] = {}

    # -- construction, used by ``interpreter`` only

    def set_relation(self, name: str, polynomial: Polynomial) -> None:
        """Declare the monic polynomial relation of a root (outermost root first in reduction)."""
        self._relations.append((self.index[name], polynomial))
        self._relations.sort(key=lambda pair: pair[0])

    # -- elements

    def generator(self, name: str) -> Element:
        """Return a generator as an element."""
        return Element(self, self.ctx.gen(self.index[name]), self.one_polynomial)

    def rational(self, value: Fraction | int) -> Element:
        """Return a rational number as an element."""
        return Element(self, self.ctx.constant(value.numerator), self.ctx.constant(value.denominator))

    def fraction(self, num: Polynomial, den: Polynomial) -> Element:
        """Return num/den reduced modulo the relations, in lowest terms, leading coefficient of den > 0."""
        if self._relations:
            num, den = self._reduce_fraction(num, den)
        if num.is_zero():
            return self.zero
        require_small(max(len(num), len(den)), MOST_TERMS)
        if not den.is_one():
            common = common_factor(num, den)
            if not common.is_one():
                num, den = num / common, den / common
            if den.leading_coefficient() < 0:
                num, den = -num, -den
        return Element(self, num, den)

    def _reduce_fraction(self, num: Polynomial, den: Polynomial) -> tuple[Polynomial, Polynomial]:
        num, den = self.reduce(num), self.reduce(den)
        if den.is_zero():
            raise UndefinedError
        multiplier = self.rationaliser(den)
        if multiplier is not None:
            num, den = self.reduce(times(num, multiplier)), self.reduce(times(den, multiplier))
        return num, den

    def reduce(self, polynomial: Polynomial) -> Polynomial:
        """Return the normal form of a polynomial modulo the relations of the roots."""
        for index, relation in self._relations:
            degree = polynomial.degrees()[index]
            if degree >= relation.degrees()[index]:
                require_small(degree * len(polynomial) * len(relation), MOST_PAIRS)
                polynomial = divmod(polynomial, relation)[1]
                require_small(len(polynomial), MOST_TERMS)
        return polynomial

    def rationaliser(self, polynomial: Polynomial) -> Polynomial | None:
        """Return a nonzero multiplier that frees a polynomial of its quadratic roots (None: none needed).

        For g² = a + b g the conjugate of g is b - g; the product of p with its conjugate is free of g.
        """
        multiplier = None
        for index, relation in self._relations:
            if polynomial.degrees()[index] <= 0 or relation.degrees()[index] != 2:
                continue
            conjugate = self.conjugate(polynomial, index, relation)
            product = self.reduce(times(polynomial, conjugate))
            if product.is_zero():
                raise UndecidedError(
                    "two roots in the model depend on each other in a way that was not found"
                )
            polynomial = product
            multiplier = conjugate if multiplier is None else self.reduce(times(multiplier, conjugate))
        return multiplier

    def conjugate(self, polynomial: Polynomial, index: int, relation: Polynomial) -> Polynomial:
        """Return the polynomial with the quadratic root g replaced by its conjugate b - g."""
        g = self.ctx.gen(index)
        linear = -(relation - g * g).derivative(index)
        images = list(self.ctx.gens())
        images[index] = linear - g
        return self.reduce(polynomial.compose(*images))

    def norm(self, polynomial: Polynomial) -> Polynomial:
        """Return the norm over the field without roots: zero exactly where the polynomial is.

        The resultant with g^d - … is the product of the polynomial over all conjugates of g.
        """
        for index, relation in self._relations:
            degree = polynomial.degrees()[index]
            if degree > 0:
                require_small(degree * relation.degrees()[index] * len(polynomial), _LARGEST_NORM)
                polynomial = polynomial.resultant(relation, index)
        return polynomial

    @property
    def has_roots(self) -> bool:
        """Whether there are algebraic generators (products then need ``reduce``)."""
        return bool(self._relations)

    @property
    def relations(self) -> tuple[tuple[int, Polynomial], ...]:
        """The algebraic generators by index, with their monic relations."""
        return tuple(self._relations)

    # -- the derivation

    def derivative(self, index: int) -> Element:
        """Return g' of one generator, from its rule."""
        known = self._derivatives.get(index)
        if known is None:
            known = self._derivatives[index] = self._derivation(self.generators[index])
        return known

    def varies(self, index: int) -> bool:
        """Whether a generator depends on time."""
        return self.generators[index].kind in {"time", "jet"} or bool(self.derivative(index))

    def derive(self, element: Element) -> Element:
        """Return the time derivative of an element."""
        numerator = self._derive_polynomial(element.num)
        if element.den.is_one():
            return numerator
        den = Element(self, element.den, self.one_polynomial)
        return (numerator - element * self._derive_polynomial(element.den)) / den

    def _derive_polynomial(self, polynomial: Polynomial) -> Element:
        total = self.zero
        for index, degree in enumerate(polynomial.degrees()):
            if degree > 0 and self.varies(index):
                partial = Element(self, polynomial.derivative(index), self.one_polynomial)
                total = total + partial * self.derivative(index)
        return total


def common_denominator(elements: Iterable[Element], one: Polynomial) -> Polynomial:
    """Return the least common multiple of the denominators."""
    return fold(least_common_multiple, (element.den for element in elements), one)


def least_common_multiple(a: Polynomial, b: Polynomial) -> Polynomial:
    """Return a least common multiple of two nonzero polynomials."""
    if a == b or b.is_one():
        return a
    if a.is_one():
        return b
    return times(a, b / common_factor(a, b))
