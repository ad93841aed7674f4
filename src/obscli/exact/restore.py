"""From polynomials in half-angle tangents back to expressions with sines and cosines.

A row scaled by (2/(1 + τ²))^d, d = ⌈deg/2⌉, is polynomial in c = cos θ and linear in s = sin θ:

    2^d τ^i/(1 + τ²)^d = (1 - c)^(i/2) (1 + c)^(d - i/2)              for even i
                       = s (1 - c)^((i-1)/2) (1 + c)^(d - (i+1)/2)    for odd i

All entries of a row (a combination, a direction) are scaled alike, so the row keeps its meaning. Roots,
exponentials and everything else are printed by their meaning.
"""

from __future__ import annotations

from functools import reduce as fold
from math import gcd, prod
from typing import TYPE_CHECKING

from flint import Ordering, fmpz_mpoly_ctx

from obscli.exact.polynomial import MOST_PAIRS, polynomial_coefficients, require_small
from obscli.model.expression import Apply, Expression, add, divide, multiply, number, power


if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from flint import fmpz

    from obscli.exact.field import Element, Generator
    from obscli.exact.polynomial import Polynomial
    from obscli.exact.reader import Reader


class Restorer:
    """Writes rows over the field of an interpreter as expressions, trigonometric form restored."""

    def __init__(self, interpreter: Reader) -> None:
        generators = interpreter.field.generators
        self._angles = [k for k, g in enumerate(generators) if g.kind == "angle"]
        plain = [k for k, g in enumerate(generators) if g.kind != "angle"]
        self._plain = sorted(plain, key=lambda k: (generators[k].writing_order, k))
        self._place = {k: position for position, k in enumerate(self._plain)}
        names = [f"p{k}" for k in self._plain] + [f"{f}{k}" for k in self._angles for f in "cs"]
        self._ctx = fmpz_mpoly_ctx.get(names or ["unused"], Ordering.lex)
        self._meanings = [generators[k].meaning for k in self._plain]
        self._cos = {k: len(self._plain) + 2 * i for i, k in enumerate(self._angles)}
        for k in self._angles:
            self._meanings += _cosine_and_sine(generators[k])

    def row(self, row: Mapping[int, Polynomial]) -> dict[int, Expression]:
        """Return a row (scaled as a whole) as expressions: content removed, first entry with + sign."""
        degrees = self._halves(row.values())
        restored = {j: self._restore(p, degrees) for j, p in row.items()}
        content = fold(lambda a, b: a.gcd(b), restored.values())
        first = restored[min(restored)]
        if (first / content).leading_coefficient() < 0:
            content = -content
        return {j: self._expression(p / content) for j, p in restored.items()}

    def element(self, element: Element) -> Expression:
        """Return one field element as an expression."""
        if not element:
            return number(0)
        pair = self.row_unscaled([element.num, element.den])
        return divide(pair[0], pair[1])

    def in_one_function(self, polynomial: Polynomial, angle: int) -> tuple[str, list[Polynomial]] | None:
        """Return a polynomial as one in the cosine, or in the sine, of an angle, if it is, by degree."""
        restored = self._restore(polynomial, {angle: (polynomial.degrees()[angle] + 1) // 2})
        place = self._cos[angle]
        c, s = self._ctx.gen(place), self._ctx.gen(place + 1)
        for function, index, form in (
            ("cos", place, restored),
            ("sin", place + 1, divmod(restored, c * c + s * s - 1)[1]),
        ):
            if form.degrees()[2 * place + 1 - index] <= 0:
                return function, polynomial_coefficients(form, index)
        return None

    def polynomial(self, polynomial: Polynomial) -> Expression:
        """Return a polynomial up to a constant factor (and powers of cos θ/2), for a condition = 0."""
        restored = self._restore(polynomial, self._halves([polynomial]))
        content = gcd(*(int(c) for c in restored.coeffs()))
        shortest = self._shorten(restored / content)
        return self._expression(-shortest if shortest.leading_coefficient() < 0 else shortest)

    def row_unscaled(self, entries: Iterable[Polynomial]) -> list[Expression]:
        """Return polynomials scaled alike by a common factor, without removing content or sign."""
        entries = list(entries)
        degrees = self._halves(entries)
        restored = [self._restore(p, degrees) for p in entries]
        content = gcd(*(int(c) for p in restored for c in p.coeffs()))
        return [self._expression(p / content) for p in restored]

    def _halves(self, polynomials: Iterable[Polynomial]) -> dict[int, int]:
        """Return ⌈deg/2⌉ in each half-angle tangent over some polynomials."""
        tops = [p.degrees() for p in polynomials]
        return {k: (max((top[k] for top in tops), default=0) + 1) // 2 for k in self._angles}

    def _restore(self, polynomial: Polynomial, degrees: Mapping[int, int]) -> Polynomial:
        tables = {k: self._table(k, d) for k, d in degrees.items() if d > 0}
        if not tables:
            return self._ctx.from_dict({self._exponents(e): c for e, c in polynomial.terms()})
        require_small(len(polynomial) * prod(d + 1 for d in degrees.values()), MOST_PAIRS)
        total = self._ctx.constant(0)
        groups: dict[tuple[int, ...], dict[tuple[int, ...], fmpz]] = {}
        for exponents, coefficient in polynomial.terms():
            angle = tuple(int(exponents[k]) for k in tables)
            groups.setdefault(angle, {})[self._exponents(exponents)] = coefficient
        for angle, part in groups.items():
            term = self._ctx.from_dict(part)
            for k, i in zip(tables, angle, strict=True):
                term = term * tables[k][i]
            total = total + term
        return total

    def _exponents(self, exponents: tuple[int, ...]) -> tuple[int, ...]:
        plain = tuple(exponents[k] for k in self._plain)
        return (*plain, *([0] * (self._ctx.nvars() - len(plain))))

    def _table(self, k: int, d: int) -> list[Polynomial]:
        """Return 2^d τ^i/(1 + τ²)^d for i = 0 … 2d as polynomials in c and s."""
        c, s = self._ctx.gen(self._cos[k]), self._ctx.gen(self._cos[k] + 1)
        table = []
        for i in range(2 * d + 1):
            half = i // 2
            even = (1 - c) ** half * (1 + c) ** (d - half) if i % 2 == 0 else None
            table.append(s * (1 - c) ** half * (1 + c) ** (d - half - 1) if even is None else even)
        return table

    def _expression(self, polynomial: Polynomial) -> Expression:
        shortest = self._shorten(polynomial)
        return add(*(self._term(exponents, coefficient) for exponents, coefficient in shortest.terms()))

    def _shorten(self, polynomial: Polynomial) -> Polynomial:
        """Write cos² as 1 - sin² for an angle where that has fewer terms: 1 - cos² becomes sin²."""
        for k in self._angles:
            c, s = self._ctx.gen(self._cos[k]), self._ctx.gen(self._cos[k] + 1)
            other = divmod(polynomial, c * c + s * s - 1)[1]
            if len(other) < len(polynomial):
                polynomial = other
        return polynomial

    def _term(self, exponents: tuple[int, ...], coefficient: fmpz) -> Expression:
        factors = (power(self._meanings[k], int(e)) for k, e in enumerate(exponents) if e)
        return multiply(number(int(coefficient)), *factors)


def _cosine_and_sine(generator: Generator) -> list[Expression]:
    assert generator.argument is not None
    return [Apply("cos", generator.argument), Apply("sin", generator.argument)]
