"""Expressions printed in the grammar of the file, so that reading the text gives the same function."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

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
    negate,
    postorder,
    rebuild,
)
from obscli.model.system import Covector


SUM: Final = 1
PRODUCT: Final = 2
POWER: Final = 3
ATOM: Final = 4
LONGEST: Final = 200_000
_LONG: Final = 1000


@dataclass(frozen=True, slots=True)
class Piece:
    """A printed expression without its sign: the sign, the text, how tightly it binds."""

    negative: bool
    text: str
    binding: int

    @property
    def signed(self) -> str:
        """The text with its sign."""
        return f"-{self.text}" if self.negative else self.text

    def within(self, binding: int) -> str:
        """Return the text for a place that needs something binding at least so tightly."""
        return f"({self.signed})" if self.negative or self.binding < binding else self.text


def to_text(expression: Expression) -> str:
    """Return the expression in the grammar of the model file."""
    size = expanded_size(expression)
    if size > LONGEST:
        return f"(an expression of {size:.3g} parts)"
    return printed(expression, _piece).signed


def decimal_text(expression: Expression) -> str:
    """Return the expression with its long fractions as decimals: for numbers that were measured."""
    written: dict[int, Expression] = {}
    for node in postorder(expression):
        if isinstance(node, Number) and node.value.denominator >= _LONG:
            size = Symbol(f"{float(abs(node.value)):.10g}")
            written[id(node)] = negate(size) if node.value < 0 else size
        else:
            parts = children(node)
            written[id(node)] = rebuild(node, tuple(written[id(part)] for part in parts)) if parts else node
    return to_text(written[id(expression)])


def expanded_size(root: Expression) -> int:
    """Return how many parts the expression has when nothing is shared."""
    sizes: dict[int, int] = {}
    for node in postorder(root):
        sizes[id(node)] = 1 + sum(sizes[id(part)] for part in children(node))
    return sizes[id(root)]


def printed(root: Expression, write: Callable[[Expression, Mapping[int, Piece]], Piece]) -> Piece:
    """Print from the leaves up; ``write`` gets a node and the pieces of what is inside it."""
    pieces: dict[int, Piece] = {}
    kept: list[Expression] = []
    for node in postorder(root):
        kept.append(node)
        pieces[id(node)] = write(node, pieces)
    return pieces[id(root)]


def _piece(node: Expression, inside: Mapping[int, Piece]) -> Piece:
    match node:
        case Number(value):
            return Piece(value < 0, str(abs(value)), ATOM if value.denominator == 1 else PRODUCT)
        case Pi():
            return Piece(negative=False, text="pi", binding=ATOM)
        case Symbol(name):
            return Piece(negative=False, text=name, binding=ATOM)
        case Derivative(name, order):
            return Piece(negative=False, text="deriv(" * order + name + ")" * order, binding=ATOM)
        case Apply(function, argument):
            return Piece(negative=False, text=f"{function}({inside[id(argument)].signed})", binding=ATOM)
        case Power(base, exponent):
            return _power(inside[id(base)], exponent)
        case Sum(terms):
            return sum_of([inside[id(term)] for term in terms])
        case Product(factors):
            return _product(factors, inside)


def sum_of(terms: Sequence[Piece]) -> Piece:
    """Return the pieces added; a negative number in front goes last: ``x - 1``."""
    if terms[0].negative and terms[0].text[0].isdigit() and not terms[-1].negative:
        terms = [*terms[1:], terms[0]]
    text = terms[0].signed
    for term in terms[1:]:
        text += f" {'-' if term.negative else '+'} {term.text}"
    return Piece(negative=False, text=text, binding=SUM)


def _power(base: Piece, exponent: Fraction) -> Piece:
    if exponent < 0:
        return Piece(negative=False, text=f"1/{_power(base, -exponent).within(POWER)}", binding=PRODUCT)
    if exponent == 1:
        return base
    if exponent == Fraction(1, 2):
        return Piece(negative=False, text=f"sqrt({base.signed})", binding=ATOM)
    above = str(exponent) if exponent.denominator == 1 else f"({exponent})"
    return Piece(negative=False, text=f"{base.within(ATOM)}**{above}", binding=POWER)


def split(factors: tuple[Expression, ...]) -> tuple[Fraction, list[Expression], list[Power]]:
    """Return the number in front, the factors above and those below the fraction line."""
    coefficient, above, below = Fraction(1), list[Expression](), list[Power]()
    for factor in factors:
        if isinstance(factor, Number):
            coefficient *= factor.value
        elif isinstance(factor, Power) and factor.exponent < 0:
            below.append(factor)
        else:
            above.append(factor)
    return coefficient, above, below


def _product(factors: tuple[Expression, ...], inside: Mapping[int, Piece]) -> Piece:
    coefficient, above, below = split(factors)
    pieces = [inside[id(factor)] for factor in above]
    negative = (coefficient < 0) != (sum(piece.negative for piece in pieces) % 2 == 1)
    numerator = [Piece(negative=False, text=p.text, binding=p.binding).within(PRODUCT) for p in pieces]
    denominator = [_power(inside[id(one.base)], -one.exponent).within(POWER) for one in below]
    if abs(coefficient.numerator) != 1 or not numerator:
        numerator.insert(0, str(abs(coefficient.numerator)))
    if coefficient.denominator != 1:
        denominator.insert(0, str(coefficient.denominator))
    text = "*".join(numerator)
    if denominator:
        under = "*".join(denominator)
        text += f"/{under}" if len(denominator) == 1 else f"/({under})"
    return Piece(negative, text, PRODUCT)


def covector_text(covector: Covector, states: Sequence[str]) -> str:
    """Return the linear combination as text: ``g*psi2 - b_a1``, in the order of the states."""
    terms = []
    for state in ordered(covector, states):
        coefficient = covector[state]
        piece = Piece(negative=False, text=to_text(coefficient), binding=ATOM)
        if expanded_size(coefficient) <= LONGEST:
            piece = printed(coefficient, _piece)
        if is_unit(coefficient):
            terms.append(Piece(piece.negative, state, PRODUCT))
        else:
            body = Piece(negative=False, text=piece.text, binding=piece.binding).within(PRODUCT)
            terms.append(Piece(piece.negative, f"{body}*{state}", PRODUCT))
    return sum_of(terms).text if terms else "0"


def ordered(covector: Covector, states: Sequence[str]) -> list[str]:
    """Return the names with a coefficient, in the order of the states."""
    known = [state for state in states if state in covector]
    return known + [name for name in covector if name not in set(known)]


def is_unit(node: Expression) -> bool:
    """Whether the node is 1 or −1 as written."""
    return isinstance(node, Number) and abs(node.value) == 1
