"""Eigenvalues as readable text: ``-1/tau``, ``±i*omega``, ``-a/2 ± sqrt(a**2/4 - b)``, or a polynomial."""

from __future__ import annotations

from fractions import Fraction
from math import isqrt
from typing import TYPE_CHECKING

from obscli.exact.field import Element
from obscli.exact.hurwitz import sign
from obscli.exact.polynomial import factored, times
from obscli.model.expression import Power, Sum, Symbol, multiply, negate, power
from obscli.model.notation import to_text


if TYPE_CHECKING:
    from obscli.exact.polynomial import Polynomial
    from obscli.exact.prove import Proof
    from obscli.exact.spectrum import Factor
    from obscli.model.expression import Expression

_HALF = Fraction(1, 2)

#: Longer polynomials are not printed.
_LONGEST = 6


def eigenvalue_text(proof: Proof, factor: Factor) -> str:
    """Return the roots of an irreducible factor as text."""
    q = factor.coefficients
    if factor.degree == 1:
        return to_text(proof.restorer.element(-q[0]))
    if factor.degree == 2:
        return _pair(proof, q[1], q[0])
    if factor.degree > _LONGEST:
        return f"roots of a polynomial of degree {factor.degree}"
    terms = [
        multiply(proof.restorer.element(c), power(Symbol("s"), k)) for k, c in reversed([*enumerate(q)]) if c
    ]
    return f"roots of {to_text(Sum(tuple(terms)))}"


def _pair(proof: Proof, b: Element, c: Element) -> str:
    """Return −b/2 ± √(b²/4 − c)."""
    field = proof.exact.field
    half = b * field.rational(_HALF)
    square = half * half - c
    imaginary = sign(proof, square) == -1
    root = square_root(proof, -square if imaginary else square)
    text = to_text(root)
    size = min(text, to_text(negate(root)), key=len)  # of the two signs the one without a minus
    part = ("i" if size == "1" else f"i*{size}") if imaginary else size
    return f"{to_text(proof.restorer.element(-half))} ± {part}" if half else f"±{part}"


def square_root(proof: Proof, square: Element) -> Expression:
    """Return √square up to its sign, without a root where it is a perfect square."""
    num, den = (_root_of(one) for one in (square.num, square.den))
    if num is None or den is None:
        return Power(proof.restorer.element(square), _HALF)
    return proof.restorer.element(Element(proof.exact.field, num, den))


def _root_of(polynomial: Polynomial) -> Polynomial | None:
    """Return a polynomial whose square is the given one, None where there is none."""
    constant, factors = factored(polynomial)
    if constant < 0 or isqrt(constant) ** 2 != constant or any(k % 2 for _, k in factors):
        return None
    root = polynomial.context().constant(isqrt(constant))
    for factor, exponent in factors:
        root = times(root, factor ** (exponent // 2))
    return root
