"""The polynomials underneath the field: multivariate over Z, from FLINT.

FLINT cannot be interrupted, and ends the process where memory runs out: sizes are looked at before.
"""

from __future__ import annotations

from math import gcd, lcm
from typing import TypeAlias

from flint import fmpq, fmpq_mpoly_ctx, fmpz, fmpz_mpoly

from obscli.exact.errors import UndecidedError


Polynomial: TypeAlias = fmpz_mpoly

#: A polynomial of more terms than this ends the attempt: the system is too large for exact algebra.
MOST_TERMS = 20_000
#: So does a product with more pairs of terms (the bundled models stay under 10 000).
MOST_PAIRS = 2_000_000
#: What trial division leaves of a number is factored up to this many bits; that takes a tenth of a second.
_MOST_BITS = 140
_TRIALS = 2000


def times(a: Polynomial, b: Polynomial) -> Polynomial:
    """Return the product of two polynomials.

    Raises
    ------
    UndecidedError : it would be too large
    """
    require_small(len(a) * len(b), MOST_PAIRS)
    product: Polynomial = a * b
    return product


def common_factor(a: Polynomial, b: Polynomial) -> Polynomial:
    """Return the greatest common divisor of two polynomials.

    Raises
    ------
    UndecidedError : they are too large
    """
    require_small(max(len(a), len(b)), MOST_TERMS)
    return a.gcd(b)


def require_small(size: int, most: int) -> None:
    """Raise ``UndecidedError`` where a size is over its limit."""
    if size > most:
        raise UndecidedError("the coefficients grew too large for exact algebra")


def factored(polynomial: Polynomial) -> tuple[int, list[tuple[Polynomial, int]]]:
    """Return the content with its sign, and the irreducible factors over Z with their exponents.

    The binding cannot put factors in order over Z where a coefficient is too long for a C int; then it is
    done over Q.
    """
    try:
        constant, factors = polynomial.factor()
    except OverflowError:
        return _factored_over_q(polynomial)
    return int(constant), [(factor, int(exponent)) for factor, exponent in factors]


def _factored_over_q(polynomial: Polynomial) -> tuple[int, list[tuple[Polynomial, int]]]:
    context = polynomial.context()
    rational = fmpq_mpoly_ctx.get(context.names(), context.ordering()).from_dict(polynomial.to_dict())
    constant, factors = rational.factor()
    found = []
    for factor, exponent in factors:
        scale = lcm(*(int(fmpq(c).q) for c in factor.coeffs()))
        content = gcd(*(int(fmpq(c).p * scale / fmpq(c).q) for c in factor.coeffs()))
        whole = {e: fmpz(int(fmpq(c).p * scale / fmpq(c).q) // content) for e, c in factor.terms()}
        found.append((context.from_dict(whole), int(exponent)))
        constant *= fmpq(content, scale) ** int(exponent)
    return int(fmpq(constant).p), found


def polynomial_coefficients(polynomial: Polynomial, index: int) -> list[Polynomial]:
    """Return the coefficients of a polynomial in one variable, by rising degree."""
    degree = polynomial.degrees()[index]
    parts: list[dict[tuple[int, ...], fmpz]] = [{} for _ in range(degree + 1)]
    for exponents, coefficient in polynomial.terms():
        rest = (*exponents[:index], 0, *exponents[index + 1 :])
        parts[exponents[index]][rest] = coefficient
    context = polynomial.context()
    return [context.from_dict(part) for part in parts]


def prime_powers(number: int, *, wholly: bool = True) -> list[tuple[int, int]]:
    """Return the primes of a positive number with their exponents; not ``wholly``: the last may be composite.

    Raises
    ------
    UndecidedError : the number is too long to be factored wholly
    """
    quickly = [(int(p), int(e)) for p, e in fmpz(number).factor(trial_limit=_TRIALS)]
    rest = max((p for p, _ in quickly), default=1)
    if rest.bit_length() <= _MOST_BITS:
        return [(int(p), int(e)) for p, e in fmpz(number).factor()]
    if wholly and not fmpz(rest).is_probable_prime():
        raise UndecidedError("a number under a root is too long to be factored")
    return quickly
