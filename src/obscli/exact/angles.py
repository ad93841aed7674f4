"""Sines, cosines and exponentials of rationally dependent arguments, reduced to independent ones.

An argument θ = Σ q_i a_i splits into atoms a_i (monomials over a denominator) with rational q_i. Each
atom has one base angle b_i = s_i a_i with all q_i/s_i integers, and one generator τ_i = tan(b_i/2):

    cos b = (1 - τ²)/(1 + τ²),   sin b = 2τ/(1 + τ²),   cos kb + i sin kb = (cos b + i sin b)^k.

Exponentials likewise: exp(u) = Π exp(s_i a_i)^(q_i/s_i). By Ax's theorem these generators are
algebraically independent of each other and of the field below, since the b_i are linearly independent
over Q modulo constants; where that fails in secret (two rational functions of time that add up to a
constant) the certificate of the rank, which uses real values, fails too, and the answer is undecided.
"""

from __future__ import annotations

from fractions import Fraction
from math import gcd, lcm
from typing import TYPE_CHECKING, TypeAlias

from obscli.exact.field import Element, Generator
from obscli.exact.missing import MissingError, RefineError
from obscli.exact.naming import stable_name
from obscli.model.expression import Apply, Expression, Number, divide, multiply, number


if TYPE_CHECKING:
    from obscli.exact.polynomial import Polynomial
    from obscli.exact.reader import Reader

#: A multiple of a base angle beyond this is taken as an angle of its own (kept apart, hence only generic).
LARGEST_MULTIPLE = 64

#: Denominators of multiples of π whose sines and cosines are built from square roots.
_PARTS = (2, 4, 6, 12, 10, 8)

CosSin: TypeAlias = tuple[Element, Element]


def trigonometric(it: Reader, function: str, argument: Element) -> Element:
    """Return sin, cos or tan of an element; tan u = sin 2u/(1 + cos 2u), so that tan(b/2) reads as τ."""
    if function == "tan":
        cosine, sine = cosine_sine(it, argument + argument)
        return sine / (it.field.one + cosine)
    cosine, sine = cosine_sine(it, argument)
    return cosine if function == "cos" else sine


def cosine_sine(it: Reader, argument: Element) -> CosSin:
    """Return (cos, sin) of an element, by the addition theorem over its atoms."""
    total: CosSin = (it.field.one, it.field.zero)
    for coefficient, atom, element in split(it, argument):
        total = _rotate(total, _atom_cosine_sine(it, coefficient, atom, element))
    return total


def exponential(it: Reader, argument: Element) -> Element:
    """Return exp of an element; exp(q log u) is u^q."""
    result = it.field.one
    for coefficient, atom, element in split(it, argument):
        generator = _single_generator(it, element)
        if generator is not None and generator.function == "log" and generator.argument is not None:
            result = result * it.power(it.read(generator.argument), coefficient)
            continue
        step, multiple = _step(it, f"exp {atom}", coefficient)
        result = result * _base_exponential(it, element, step) ** multiple
    return result


def hyperbolic(it: Reader, function: str, argument: Element) -> Element:
    """Return sinh, cosh or tanh of an element through exp."""
    up = exponential(it, argument)
    down = it.field.one / up
    half = it.field.rational(Fraction(1, 2))
    if function == "sinh":
        return (up - down) * half
    if function == "cosh":
        return (up + down) * half
    return (up - down) / (up + down)


def split(it: Reader, argument: Element) -> list[tuple[Fraction, str, Element]]:
    """Split an element into rational multiples of atoms: (coefficient, name of the atom, atom).

    What can be divided is, so that t/(1 + t) = 1 - 1/(1 + t) and 1/(1 + t) share their atoms.
    """
    if not argument:
        return []
    content = _content(argument.den)
    primitive = argument.den / content
    scale = abs(int(primitive.leading_coefficient())) ** (1 + sum(map(int, argument.num.degrees())))
    whole, rest = divmod(argument.num * scale, primitive)
    parts = []
    for polynomial, below in ((whole, it.field.one_polynomial), (rest, primitive)):
        for exponents, coefficient in polynomial.terms():
            monomial = it.field.ctx.from_dict({exponents: 1})
            atom = it.field.fraction(monomial, below)
            parts.append((Fraction(int(coefficient), content * scale), _atom_name(it, monomial, below), atom))
    return parts


def _content(polynomial: Polynomial) -> int:
    return gcd(*(int(c) for c in polynomial.coeffs()))


def _atom_name(it: Reader, monomial: Polynomial, denominator: Polynomial) -> str:
    """Name an atom by its generators, so that the name survives when the field is built again."""
    return f"{stable_name(it, monomial)}/{stable_name(it, denominator)}"


def _step(it: Reader, atom: str, coefficient: Fraction) -> tuple[Fraction, int]:
    """Return the step of an atom and the integer multiple that the coefficient is of it."""
    step = it.fineness.get(atom)
    if step is None:
        step = it.fineness[atom] = abs(coefficient)
    multiple = coefficient / step
    if multiple.denominator == 1 and abs(multiple) <= LARGEST_MULTIPLE:
        return step, multiple.numerator
    finer = _rational_gcd(step, coefficient)
    if max(abs(coefficient), step) / finer <= LARGEST_MULTIPLE:
        raise RefineError(atom, finer)
    it.kept_apart.add(atom)
    return abs(coefficient), 1 if coefficient > 0 else -1


def _rational_gcd(a: Fraction, b: Fraction) -> Fraction:
    return Fraction(gcd(a.numerator, b.numerator), lcm(a.denominator, b.denominator))


def _rotate(a: CosSin, b: CosSin) -> CosSin:
    return a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]


def _multiple(it: Reader, base: CosSin, k: int) -> CosSin:
    """Return (cos kb, sin kb) from (cos b, sin b)."""
    if k < 0:
        base, k = (base[0], -base[1]), -k
    result: CosSin = (it.field.one, it.field.zero)
    for _ in range(k):
        result = _rotate(result, base)
    return result


def _atom_cosine_sine(it: Reader, coefficient: Fraction, atom: str, element: Element) -> CosSin:
    generator = _single_generator(it, element)
    if generator is not None and generator.kind == "pi":
        exact = _rational_turn(it, coefficient)
        if exact is not None:
            return exact
    if generator is not None and generator.function == "atan" and (coefficient / 2).denominator == 1:
        assert generator.argument is not None
        return _multiple(it, _from_tangent(it, it.read(generator.argument)), (coefficient / 2).numerator)
    if generator is not None and generator.function in {"asin", "atan"} and coefficient.denominator == 1:
        return _multiple(it, _of_inverse(it, generator), coefficient.numerator)
    step, multiple = _step(it, atom, coefficient)
    return _multiple(it, _base_angle(it, element, step), multiple)


def _single_generator(it: Reader, element: Element) -> Generator | None:
    """Return the generator that an element is, if it is one."""
    if not element.den.is_one():
        return None
    for k, gen in enumerate(it.field.ctx.gens()):
        if element.num == gen and k < len(it.field.generators):
            return it.field.generators[k]
    return None


def _base_angle(it: Reader, element: Element, step: Fraction) -> CosSin:
    field = it.field
    name = f"tan({step}*{_atom_name(it, element.num, element.den)}/2)"
    if name not in field.index:
        argument = _scaled(it, element, step)
        meaning = Apply("tan", multiply(number(Fraction(1, 2)), argument))
        numeric = it.is_numeric(element)
        raise MissingError(Generator(name, "angle", meaning, argument=argument, numeric=numeric))
    return _from_tangent(it, field.generator(name))


def _from_tangent(it: Reader, tangent: Element) -> CosSin:
    """cos, sin of an angle by the tangent of its half: (1 - τ²)/(1 + τ²), 2τ/(1 + τ²)."""
    one = it.field.one
    square = tangent * tangent
    return (one - square) / (one + square), (tangent + tangent) / (one + square)


def _base_exponential(it: Reader, element: Element, step: Fraction) -> Element:
    name = f"exp({step}*{_atom_name(it, element.num, element.den)})"
    if name not in it.field.index:
        numeric = it.is_numeric(element)
        argument = _scaled(it, element, step)
        meaning = Apply("exp", argument)
        raise MissingError(
            Generator(name, "exponential", meaning, argument=argument, positive=True, numeric=numeric)
        )
    return it.field.generator(name)


def _scaled(it: Reader, element: Element, step: Fraction) -> Expression:
    return divide(multiply(Number(step), it.expression(element.num)), it.expression(element.den))


def _of_inverse(it: Reader, generator: Generator) -> CosSin:
    """cos, sin of asin(u): (√(1-u²), u); of atan(u): (1, u)/√(1+u²)."""
    assert generator.argument is not None
    u = it.read(generator.argument)
    one = it.field.one
    if generator.function == "asin":
        return it.power(one - u * u, Fraction(1, 2)), u
    cosine = one / it.power(one + u * u, Fraction(1, 2))
    return cosine, u * cosine


def _rational_turn(it: Reader, turn: Fraction) -> CosSin | None:
    """(cos, sin) of a rational multiple of π, in square roots where its denominator divides 8, 10 or 12."""
    for parts in _PARTS:
        if parts % turn.denominator == 0:
            return _multiple(it, _part_of_turn(it, parts), int(turn * parts) % (2 * parts))
    return None


def _part_of_turn(it: Reader, parts: int) -> CosSin:
    """(cos, sin) of π/parts."""

    def root(value: Element | int) -> Element:
        element = it.field.rational(value) if isinstance(value, int) else value
        return it.power(element, Fraction(1, 2))

    one, half, quarter = (it.field.rational(Fraction(1, k)) for k in (1, 2, 4))
    match parts:
        case 2:
            return it.field.zero, one
        case 4:
            return root(2) * half, root(2) * half
        case 6:
            return root(3) * half, half
        case 12:
            return (root(6) + root(2)) * quarter, (root(6) - root(2)) * quarter
        case 10:
            return root(it.field.rational(10) + root(20)) * quarter, (root(5) - one) * quarter
    cosine = root(it.field.rational(2) + root(2)) * half
    return cosine, root(2) * quarter / cosine
