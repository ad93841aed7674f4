"""Expressions in LaTeX."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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
)
from obscli.model.latex import latex_name
from obscli.model.system import Covector
from obscli.model.written import (
    ATOM,
    LONGEST,
    POWER,
    PRODUCT,
    Piece,
    expanded_size,
    is_unit,
    ordered,
    printed,
    split,
    sum_of,
)


_NAMED: Final = {
    **{name: f"\\{name}" for name in ("sin", "cos", "tan", "exp", "sinh", "cosh", "tanh")},
    "log": "\\ln",
    **{f"a{name}": f"\\arc{name}" for name in ("sin", "cos", "tan")},
    **{f"a{name}": f"\\operatorname{{ar{name}}}" for name in ("sinh", "cosh", "tanh")},
}
_NO_NAMES: Final[Mapping[str, str]] = {}


def to_latex(expression: Expression, latex_names: Mapping[str, str] = _NO_NAMES) -> str:
    """Return the expression in LaTeX; ``latex_names`` overrides the spelling of names."""
    size = expanded_size(expression)
    if size > LONGEST:
        return f"\\text{{(an expression of {size:.3g} parts)}}"
    return _printed(expression, latex_names).signed


def covector_latex(
    covector: Covector, states: Sequence[str], latex_names: Mapping[str, str] = _NO_NAMES
) -> str:
    """Return the linear combination in LaTeX, in the order of the states."""
    terms = []
    for state in ordered(covector, states):
        coefficient = covector[state]
        name = latex_names.get(state) or latex_name(state)
        if expanded_size(coefficient) > LONGEST:
            terms.append(Piece(negative=False, text=f"{to_latex(coefficient)}\\,{name}", binding=PRODUCT))
            continue
        piece = _printed(coefficient, latex_names)
        body = _within(Piece(negative=False, text=piece.text, binding=piece.binding), PRODUCT)
        text = name if is_unit(coefficient) else f"{body}\\,{name}"
        terms.append(Piece(piece.negative, text, PRODUCT))
    return sum_of(terms).text if terms else "0"


def _printed(expression: Expression, names: Mapping[str, str]) -> Piece:
    return printed(expression, lambda node, inside: _piece(node, inside, names))


def _atom(text: str) -> Piece:
    return Piece(negative=False, text=text, binding=ATOM)


def _within(piece: Piece, binding: int) -> str:
    if piece.negative or piece.binding < binding:
        return f"\\left({piece.signed}\\right)"
    return piece.text


def _piece(node: Expression, inside: Mapping[int, Piece], names: Mapping[str, str]) -> Piece:
    match node:
        case Number(value):
            return _number(value)
        case Pi():
            return _atom("\\pi")
        case Symbol(name):
            return _atom(names.get(name) or latex_name(name))
        case Derivative(name, order):
            return _derivative(names.get(name) or latex_name(name), order)
        case Apply(function, argument):
            return _atom(f"{_NAMED[function]}\\left({inside[id(argument)].signed}\\right)")
        case Power(base, exponent):
            return _power(inside[id(base)], exponent)
        case Sum(terms):
            return sum_of([inside[id(term)] for term in terms])
        case Product(factors):
            return _product(factors, inside)


def _number(value: Fraction) -> Piece:
    top, bottom = abs(value.numerator), value.denominator
    text = str(top) if bottom == 1 else f"\\frac{{{top}}}{{{bottom}}}"
    return Piece(value < 0, text, ATOM if bottom == 1 else POWER)


def _derivative(name: str, order: int) -> Piece:
    if order <= 2:
        return _atom(f"\\{'d' * order}ot{{{name}}}")
    return Piece(negative=False, text=f"{{{name}}}^{{({order})}}", binding=POWER)


def _power(base: Piece, exponent: Fraction) -> Piece:
    if exponent < 0:
        under = _power(base, -exponent)
        return Piece(negative=False, text=f"\\frac{{1}}{{{under.signed}}}", binding=POWER)
    if exponent == 1:
        return base
    if exponent == Fraction(1, 2):
        return _atom(f"\\sqrt{{{base.signed}}}")
    return Piece(negative=False, text=f"{{{_within(base, ATOM)}}}^{{{exponent}}}", binding=POWER)


def _product(factors: tuple[Expression, ...], inside: Mapping[int, Piece]) -> Piece:
    coefficient, above, below = split(factors)
    pieces = [inside[id(factor)] for factor in above]
    negative = (coefficient < 0) != (sum(piece.negative for piece in pieces) % 2 == 1)
    top = [_within(Piece(negative=False, text=p.text, binding=p.binding), PRODUCT) for p in pieces]
    bottom = [_within(_power(inside[id(one.base)], -one.exponent), PRODUCT) for one in below]
    if abs(coefficient.numerator) != 1 or not top:
        top.insert(0, str(abs(coefficient.numerator)))
    if coefficient.denominator != 1:
        bottom.insert(0, str(coefficient.denominator))
    numerator = "\\,".join(top)
    if not bottom:
        return Piece(negative, numerator, PRODUCT)
    denominator = "\\,".join(bottom)
    return Piece(negative, f"\\frac{{{numerator}}}{{{denominator}}}", POWER)
