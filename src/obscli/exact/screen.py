"""The rank on a hypersurface of constants, or at an instant, at a random point of it modulo a prime.

A full rank found is certain (a minor that is nonzero modulo p at a point of q = 0 is nonzero on q = 0, the
generators being independent there); a drop is only a reason to look closer.
"""

from __future__ import annotations

import random
from typing import TYPE_CHECKING

from flint import nmod_poly

from obscli.exact.errors import UndecidedError
from obscli.exact.saturation import stays_independent
from obscli.exact.series import PRIME


if TYPE_CHECKING:
    from collections.abc import Iterator

    from obscli.exact.exact_system import ExactSystem
    from obscli.exact.polynomial import Polynomial
    from obscli.exact.saturation import Saturation

_ATTEMPTS = 12


def full_rank_on(exact: ExactSystem, polynomial: Polynomial, saturation: Saturation) -> bool:
    """Whether the rank is full at some random point of polynomial = 0 modulo a prime."""
    for chosen in points_on(polynomial, attempts=2):
        try:
            if stays_independent(exact, saturation, chosen):
                return True
        except UndecidedError:
            continue
    return False


def points_on(polynomial: Polynomial, attempts: int = 1) -> Iterator[dict[int, int]]:
    """Yield values modulo PRIME of the generators in a polynomial at random zeros of it."""
    source = random.Random(str(polynomial))  # noqa: S311  (a random point, no secret)
    degrees = polynomial.degrees()
    used = [k for k, degree in enumerate(degrees) if degree > 0]
    target = min(used, key=lambda k: degrees[k])
    found = 0
    for _ in range(_ATTEMPTS):
        chosen = {k: source.randrange(2, PRIME) for k in used if k != target}
        coefficients = [0] * (int(degrees[target]) + 1)
        for exponents, coefficient in polynomial.terms():
            value = int(coefficient) % PRIME
            for k, e in enumerate(exponents):
                if e and k != target:
                    value = value * pow(chosen[k], int(e), PRIME) % PRIME
            coefficients[int(exponents[target])] += value
        roots = _roots(nmod_poly([c % PRIME for c in coefficients], PRIME))
        if roots:
            yield {**chosen, target: source.choice(roots)}
            found += 1
            if found == attempts:
                return


def _roots(polynomial: nmod_poly) -> list[int]:
    if polynomial.degree() < 1:
        return []
    if polynomial.degree() == 1:
        return [int(-polynomial[0] / polynomial[1])]
    return [int(-f[0] / f[1]) for f, _ in polynomial.factor()[1] if f.degree() == 1]
