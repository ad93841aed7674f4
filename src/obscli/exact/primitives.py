"""Logarithms and inverse functions as generators with their derivative rule.

log(u): u is written over its irreducible factors; if a product of powers of earlier arguments equals it,
log u is that combination (log(ab) = log a + log b), otherwise it is adjoined. asinh, acosh and atanh are
logarithms; acos u = π/2 - asin u; atan and asin are adjoined, atan(-u) referred to atan(u).
"""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from flint import fmpq, fmpq_mat

from obscli.exact.errors import UndecidedError, UndefinedError
from obscli.exact.field import Element, Generator
from obscli.exact.missing import MissingError
from obscli.exact.naming import stable_name
from obscli.exact.roots import exponential_generator, irreducible_factors, pure_root, sign_of
from obscli.model.expression import Apply, Expression, divide, number


if TYPE_CHECKING:
    from obscli.exact.reader import Reader

_HALF = Fraction(1, 2)
#: Squares of positive sines and tangents of multiples of π, with the multiple.
_TURNS = {
    "asin": {
        Fraction(1, 4): Fraction(1, 6),
        Fraction(1, 2): Fraction(1, 4),
        Fraction(3, 4): Fraction(1, 3),
        Fraction(1): Fraction(1, 2),
    },
    "atan": {Fraction(1, 3): Fraction(1, 6), Fraction(1): Fraction(1, 4), Fraction(3): Fraction(1, 3)},
}


def primitive(it: Reader, function: str, argument: Element) -> Element:
    """Return log or an inverse function of an element."""
    field = it.field
    match function:
        case "log":
            return _logarithm(it, argument)
        case "asinh":
            return _asinh(it, argument)
        case "acosh":
            return _logarithm(it, argument + it.power(argument * argument - field.one, _HALF))
        case "atanh":
            half = field.rational(_HALF)
            return half * _logarithm(it, (field.one + argument) / (field.one - argument))
        case "acos":
            return it.constant_pi() * field.rational(_HALF) - _inverse(it, "asin", argument)
        case "asin" | "atan":
            return _inverse(it, function, argument)
    raise UndecidedError(f"the function {function} is not known to the exact side")


def _asinh(it: Reader, argument: Element) -> Element:
    if argument and argument.num.leading_coefficient() < 0:
        return -_asinh(it, -argument)
    root = it.power(it.field.one + argument * argument, _HALF)
    return _logarithm(it, argument + root)


def _logarithm(it: Reader, argument: Element) -> Element:
    field = it.field
    if not argument:
        raise UndefinedError
    result, rest = field.zero, argument
    for factor, exponent in irreducible_factors(argument):
        generator = exponential_generator(it, factor)
        if generator is not None:
            assert generator.argument is not None
            result = result + field.rational(exponent) * it.read(generator.argument)
            rest = rest / Element(field, factor, field.one_polynomial) ** exponent
            continue
        root = pure_root(it, factor)
        if root is not None:
            inner = _logarithm(it, it.read(root.relation[0]))
            result = result + field.rational(Fraction(exponent, root.order)) * inner
            rest = rest / Element(field, factor, field.one_polynomial) ** exponent
    return result + _combination_of_logarithms(it, rest) if rest != field.one else result


def _combination_of_logarithms(it: Reader, argument: Element) -> Element:
    """Return log(argument) as a rational combination of known logarithms, or ask for a new one.

    Arguments of logarithms are positive, so their signs agree: |u| = Π |u_j|^q_j is u = Π u_j^q_j.
    """
    field = it.field
    known = it.logarithms
    coefficients = _solve([_exponents(u) for _, u in known], _exponents(argument))
    if coefficients is None:
        return _adjoin(it, "log", argument, divide(number(1), it.element_expression(argument)))
    total = field.zero
    for (name, _), coefficient in zip(known, coefficients, strict=True):
        total = total + field.rational(coefficient) * field.generator(name)
    return total


def _exponents(element: Element) -> dict[str, int]:
    return {
        str(factor): exponent for factor, exponent in irreducible_factors(element) if not (-factor).is_one()
    }


def _solve(vectors: list[dict[str, int]], target: dict[str, int]) -> list[Fraction] | None:
    """Solve Σ c_k vectors_k = target over Q; None where there is no solution."""
    keys = sorted({key for vector in [*vectors, target] for key in vector})
    columns = [*vectors, target]
    matrix = fmpq_mat(len(keys), len(columns), [v.get(key, 0) for key in keys for v in columns])
    reduced, rank = matrix.rref()
    solution = [Fraction(0)] * len(vectors)
    for row in range(rank):
        pivot = next(k for k in range(len(columns)) if reduced[row, k] != 0)
        if pivot == len(vectors):
            return None
        value: fmpq = reduced[row, len(vectors)]
        solution[pivot] = Fraction(int(value.p), int(value.q))
    return solution


def _inverse(it: Reader, function: str, argument: Element) -> Element:
    """Return asin or atan; odd, so that the leading sign comes out."""
    field = it.field
    if not argument:
        return field.zero
    if argument.num.leading_coefficient() < 0:
        return -_inverse(it, function, -argument)
    exact = _known_angle(it, function, argument)
    if exact is not None:
        return exact
    square = argument * argument
    if function == "atan":
        rule = field.one / (field.one + square)
    else:
        rule = field.one / it.power(field.one - square, _HALF)
    return _adjoin(it, function, argument, it.element_expression(rule))


def _known_angle(it: Reader, function: str, argument: Element) -> Element | None:
    """atan 1 = π/4, asin 1/2 = π/6, and the like, as multiples of π."""
    field = it.field
    if not it.is_numeric(argument) or sign_of(it, argument.num) != 1 or sign_of(it, argument.den) != 1:
        return None
    square = argument * argument
    for value, turn in _TURNS[function].items():
        if square == field.rational(value):
            return it.constant_pi() * field.rational(turn)
    return None


def _adjoin(it: Reader, function: str, argument: Element, rule: Expression) -> Element:
    """Return the primitive as a generator whose derivative is argument' · rule."""
    name = f"{function}({stable_name(it, argument.num)}/{stable_name(it, argument.den)})"
    if name not in it.field.index:
        text = it.element_expression(argument)
        raise MissingError(
            Generator(
                name,
                "primitive",
                Apply(function, text),
                argument=text,
                function=function,
                relation=(rule,),
                numeric=it.is_numeric(argument),
            )
        )
    return it.field.generator(name)
