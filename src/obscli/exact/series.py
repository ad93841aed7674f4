"""Power series of the generators at a random point modulo a prime: the fast screen of the exact side.

Values modulo p prove independence (a minor that is nonzero modulo p is nonzero), never dependence.
p is a safe prime, p = 2q + 1 with p = 3 (mod 4): square roots are powers, odd roots are unique. All primes up
to 101 are squares modulo p, so that the roots of numbers made of them exist, √13 as well as √0.97.
A generator with g' = F(g) gets its series term by term from the series of F.
"""

from __future__ import annotations

import random
from typing import TYPE_CHECKING

from flint import nmod_poly

from obscli.exact.errors import UndecidedError
from obscli.exact.field import Element, Field


if TYPE_CHECKING:
    from collections.abc import Mapping

    from obscli.exact.polynomial import Polynomial

PRIME = 2046178031645777039
_ATTEMPTS = 40


class BadPointError(Exception):
    """The random point hit a zero denominator or a non-residue; another one is tried."""


class SeriesPoint:
    """Truncated series, in t - t0, of every generator of a field at one random point modulo PRIME.

    Parameters
    ----------
    field : the differential field
    length : number of terms kept
    seed : seed of the random point
    chosen : values of generators (by index) that are not random; None for the generator at infinity
    """

    def __init__(self, field: Field, length: int, seed: int, chosen: Mapping[int, int] | None = None) -> None:
        self.field = field
        self.length = length
        self._random = random.Random(seed)  # noqa: S311  (a random point, no secret)
        self._chosen = dict(chosen or {})
        self.series: list[nmod_poly] = [nmod_poly([0], PRIME)] * len(field.generators)
        for _ in range(_ATTEMPTS):
            try:
                self._draw()
            except BadPointError:
                continue
            return
        raise UndecidedError("no point was found at which all coefficients exist modulo a prime")

    def value(self, element: Element) -> nmod_poly:
        """Return the series of an element."""
        num = self._polynomial(element.num, self.length)
        return num if element.den.is_one() else self._quotient(num, element.den, self.length)

    # -- the series of the generators

    def _draw(self) -> None:
        field = self.field
        differential = []
        for k in reversed(range(len(field.generators))):
            generator = field.generators[k]
            if generator.kind == "time":
                self.series[k] = nmod_poly([self._initial(k), 1][: self.length], PRIME)
            elif generator.kind == "jet":
                if generator.order == 0:
                    self._draw_jets(generator.function)
            elif generator.kind != "root":
                self.series[k] = nmod_poly([self._initial(k)], PRIME)
                differential.append(k)
        for k, relation in sorted(field.relations, reverse=True):
            self.series[k] = nmod_poly([self._root_value(k, relation)], PRIME)
            differential.append(k)
        self._integrate([k for k in differential if field.varies(k)])

    def _initial(self, k: int) -> int:
        return self._chosen[k] if k in self._chosen else self._random.randrange(2, PRIME)

    def _draw_jets(self, name: str) -> None:
        jets = {
            g.order: k for k, g in enumerate(self.field.generators) if g.kind == "jet" and g.function == name
        }
        top = max(jets)
        series = nmod_poly([self._random.randrange(PRIME) for _ in range(self.length + top)], PRIME)
        for order in range(top + 1):
            self.series[jets[order]] = series.truncate(self.length)
            series = series.derivative()

    def _root_value(self, k: int, relation: Polynomial) -> int:
        """Solve g² = a + b g or g^d = a for the constant term of the series."""
        g = self.field.ctx.gen(k)
        degree = int(relation.degrees()[k])
        linear = (relation - g**degree).derivative(k)
        a = int(self._polynomial(g**degree - relation + linear * g, 1)[0])
        if degree == 2:
            b = int(self._polynomial(-linear, 1)[0])
            half = b * pow(2, -1, PRIME) % PRIME
            return (half + _square_root((a + half * half) % PRIME)) % PRIME
        value = a
        while degree % 2 == 0:
            value, degree = _square_root(value), degree // 2
        return pow(value, pow(degree, -1, (PRIME - 1) // 2), PRIME) if degree > 1 else value

    def _integrate(self, indices: list[int]) -> None:
        for length in range(1, self.length):
            updates = []
            inverse = pow(length, -1, PRIME)
            for k in indices:
                rule = self.field.derivative(k)
                num = self._polynomial(rule.num, length)
                rate = num if rule.den.is_one() else self._quotient(num, rule.den, length)
                updates.append((k, int(rate[length - 1]) * inverse % PRIME))
            for k, coefficient in updates:
                self.series[k] = self.series[k] + nmod_poly([0] * length + [coefficient], PRIME)

    # -- evaluation

    def _polynomial(self, polynomial: Polynomial, length: int) -> nmod_poly:
        total = nmod_poly([0], PRIME)
        for exponents, coefficient in polynomial.terms():
            product = nmod_poly([int(coefficient) % PRIME], PRIME)
            for k, exponent in enumerate(exponents):
                if exponent:
                    product = product.mul_low(self.series[k].pow_trunc(int(exponent), length), length)
            total += product
        return total

    def _quotient(self, num: nmod_poly, den: Polynomial, length: int) -> nmod_poly:
        below = self._polynomial(den, length)
        if int(below[0]) == 0:
            raise BadPointError
        return num.mul_low(below.inverse_series_trunc(length), length)


def _square_root(value: int) -> int:
    """Return the square root that is a square itself (p = 3 mod 4)."""
    root = pow(value, (PRIME + 1) // 4, PRIME)
    if root * root % PRIME != value:
        raise BadPointError
    return root
