"""Rational powers: u^(p/q) as algebraic generators that do not secretly depend on each other.

u = c Π f_i^(e_i) into irreducible factors. A positive factor f has one root g, g^d = f, d the least common
denominator of its exponents: such roots are independent (Kummer theory), and √2·√3 = √6, a^(1/4)² = √a.
Of the other factors full q-th powers come out of the root (with the sign that ``assume`` fixes, else
undecided); what remains, w, is for q = 2 a vector over GF(2): √w is adjoined only if w is independent of
the other radicands there, otherwise it is a product of their roots.
"""

from __future__ import annotations

from fractions import Fraction
from math import lcm
from typing import TYPE_CHECKING

from obscli.exact.errors import UndecidedError, UndefinedError
from obscli.exact.field import Element, Generator
from obscli.exact.missing import MissingError, RefineError
from obscli.exact.naming import stable_name
from obscli.exact.polynomial import factored, prime_powers
from obscli.exact.restore import Restorer
from obscli.model.expression import Power
from obscli.model.notation import to_text


if TYPE_CHECKING:
    from obscli.exact.polynomial import Polynomial
    from obscli.exact.reader import Reader


#: Roots of a higher order (a least common denominator of exponents) are not tried.
HIGHEST_ORDER = 100


def rational_power(it: Reader, base: Element, exponent: Fraction) -> Element:
    """Return base^exponent, real branch; exponent not an integer.

    Factors that are evidently positive have powers of their own; the others stay together under one root.

    Raises
    ------
    UndecidedError : a full power under an even root has a sign that ``assume`` does not fix
    UndefinedError : zero to a negative power
    """
    if not base:
        if exponent < 0:
            raise UndefinedError
        return base
    result, rest = it.field.one, it.field.one
    for factor, multiplicity in irreducible_factors(base):
        total = multiplicity * exponent
        if (exponential := exponential_generator(it, factor)) is not None:
            assert exponential.argument is not None
            result = result * it.exponential(it.read(exponential.argument) * it.field.rational(total))
        elif (root := pure_root(it, factor)) is not None:
            result = result * it.power(it.read(root.relation[0]), total / root.order)
        elif evident_sign(it, factor) == 1:
            result = result * _positive_power(it, factor, total)
        else:
            rest = rest * Element(it.field, factor, it.field.one_polynomial) ** multiplicity
    return result * _root_of_the_rest(it, rest, exponent)


def exponential_generator(it: Reader, factor: Polynomial) -> Generator | None:
    """Return the exponential that a polynomial is, if it is one."""
    return _generator(it, factor, "exponential")


def pure_root(it: Reader, factor: Polynomial) -> Generator | None:
    """Return the positive root g^d = r that a polynomial is, if it is one."""
    generator = _generator(it, factor, "root")
    return generator if generator is not None and generator.positive else None


def _generator(it: Reader, factor: Polynomial, kind: str) -> Generator | None:
    if len(factor) != 1:
        return None
    for k, generator in enumerate(it.field.generators):
        if generator.kind == kind and factor == it.field.ctx.gen(k):
            return generator
    return None


def _positive_power(it: Reader, factor: Polynomial, exponent: Fraction) -> Element:
    """Return a power of a positive irreducible polynomial f, as a power of g with g^d = f."""
    if exponent.denominator == 1:
        return Element(it.field, factor, it.field.one_polynomial) ** exponent.numerator
    atom = f"root {stable_name(it, factor)}"
    step = it.fineness.setdefault(atom, Fraction(1, exponent.denominator))
    multiple = exponent / step
    if multiple.denominator != 1:
        raise RefineError(atom, Fraction(1, lcm(step.denominator, exponent.denominator)))
    return _root(it, factor, step.denominator) ** multiple.numerator


def _root_of_the_rest(it: Reader, base: Element, exponent: Fraction) -> Element:
    """Return a power of a product of factors whose signs are not evident."""
    q = exponent.denominator
    outside, radicand = _take_out_powers(it, base, q)
    if radicand.is_one():
        return outside**exponent.numerator
    root = _square_root(it, radicand) if q == 2 else _root(it, radicand, q)
    return (outside * root) ** exponent.numerator


def _take_out_powers(it: Reader, base: Element, q: int) -> tuple[Element, Polynomial]:
    """Write base^(1/q) = outside · radicand^(1/q) with a radicand free of q-th powers."""
    field = it.field
    outside, radicand = field.one, field.one_polynomial
    for factor, exponent in irreducible_factors(base):
        whole, rest = divmod(exponent, q)
        if whole:
            piece = Element(field, factor, field.one_polynomial)
            if q % 2 == 0 and whole % 2 and _sign(it, factor) < 0:
                piece = -piece
            outside = outside * piece**whole
        radicand = radicand * factor**rest
    return outside, radicand


def irreducible_factors(base: Element) -> list[tuple[Polynomial, int]]:
    """Return irreducible polynomials (primes and -1 among them) with exponents, denominators negative."""
    context = base.num.context()
    result: dict[str, tuple[Polynomial, int]] = {}
    for polynomial, sign in ((base.num, 1), (base.den, -1)):
        constant, factors = factored(polynomial)
        numbers = [(context.constant(p), e) for p, e in prime_powers(abs(constant))]
        if constant < 0:
            numbers.append((context.constant(-1), 1))
        for factor, exponent in [*numbers, *factors]:
            known = result.get(str(factor), (factor, 0))
            result[str(factor)] = (factor, known[1] + sign * int(exponent))
    return [(factor, exponent) for factor, exponent in result.values() if exponent]


def _sign(it: Reader, polynomial: Polynomial) -> int:
    sign = sign_of(it, polynomial)
    if sign is None:
        text = to_text(Restorer(it).polynomial(polynomial))
        raise UndecidedError(
            f"the sign of {text} is not known, so its root is not determined; {_remedy(it, polynomial)}"
        )
    return sign


def _remedy(it: Reader, polynomial: Polynomial) -> str:
    """Say what a user can do about a sign that is not known."""
    used = [it.field.generators[k].kind for k, degree in enumerate(polynomial.degrees()) if degree > 0]
    if set(used) <= {"parameter"}:
        return "give `assume: positive` where it holds"
    return "write the entry without this root, with the sign that it has (`assume` is for parameters only)"


def sign_of(it: Reader, polynomial: Polynomial) -> int | None:
    """Return the sign of a polynomial where it is evident: even powers, positive generators, factors."""
    sign = evident_sign(it, polynomial)
    if sign is not None:
        return sign
    constant, factors = factored(polynomial)
    total = 1 if constant > 0 else -1
    for factor, exponent in factors:
        if exponent % 2:
            known = evident_sign(it, factor)
            if known is None:
                return None
            total *= known
    return total


def evident_sign(it: Reader, polynomial: Polynomial, *, assumed: bool = True) -> int | None:
    """Return the sign that all terms of a polynomial share, each a square times positive generators.

    With ``assumed`` false the assumptions about parameters do not count, only what is positive by nature.
    """
    generators = it.field.generators
    signs = set()
    for exponents, coefficient in polynomial.terms():
        for k, e in enumerate(exponents):
            if e % 2 and not (generators[k].positive and (assumed or generators[k].kind != "parameter")):
                return None
        signs.add(1 if coefficient > 0 else -1)
    return signs.pop() if len(signs) == 1 else None


def _square_root(it: Reader, radicand: Polynomial) -> Element:
    """Return √radicand for a squarefree radicand: a product of known roots, or a new generator."""
    field = it.field
    radicands = {
        field.generators[k].name: field.ctx.gen(k) ** 2 - relation
        for k, relation in field.relations
        if relation.degrees()[k] == 2
    }
    chosen = _dependence(radicands, radicand)
    if chosen is None:
        return _root(it, radicand, 2)
    product, roots = field.one_polynomial, field.one
    for name in chosen:
        product = product * radicands[name]
        roots = roots * field.generator(name)
    # √w = Π √w_j / |s|  with  Π w_j = w s²
    outside, rest = _take_out_powers(it, field.fraction(product, radicand), 2)
    assert rest.is_one()
    return roots / outside


def _dependence(radicands: dict[str, Polynomial], target: Polynomial) -> list[str] | None:
    """Return roots whose radicands multiply to the target up to squares, by elimination over GF(2)."""
    names = list(radicands)
    classes = [_class(radicands[name]) for name in names]
    basis: list[tuple[frozenset[str], frozenset[int]]] = []
    for k, vector in enumerate(classes):
        reduced, used = _reduce(vector, frozenset([k]), basis)
        if reduced:
            basis.append((reduced, used))
    rest, used = _reduce(_class(target), frozenset(), basis)
    return None if rest else [names[k] for k in sorted(used)]


def _reduce(
    vector: frozenset[str], used: frozenset[int], basis: list[tuple[frozenset[str], frozenset[int]]]
) -> tuple[frozenset[str], frozenset[int]]:
    for other, indices in basis:
        if min(other) in vector:
            vector, used = vector ^ other, used ^ indices
    return vector, used


def _class(polynomial: Polynomial) -> frozenset[str]:
    one = Element.__new__(Element)
    one.num, one.den = polynomial, polynomial.context().constant(1)
    return frozenset(str(factor) for factor, exponent in irreducible_factors(one) if exponent % 2)


def _root(it: Reader, radicand: Polynomial, q: int) -> Element:
    if q > HIGHEST_ORDER:
        raise UndecidedError(f"a root of order {q} is too high for exact algebra")
    meaning = Power(it.expression(radicand), Fraction(1, q))
    name = f"root{q}({stable_name(it, radicand)})"
    if name not in it.field.index:
        element = Element(it.field, radicand, it.field.one_polynomial)
        zeros = (it.expression(it.field.zero.num),) * (q - 1)
        raise MissingError(
            Generator(
                name,
                "root",
                meaning,
                order=q,
                relation=(meaning.base, *zeros),
                positive=q % 2 == 0,
                numeric=it.is_numeric(element),
            )
        )
    return it.field.generator(name)
