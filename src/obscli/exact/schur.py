"""Whether the roots of a polynomial over the constants lie inside the unit circle, exactly.

With s = (1 + w)/(1 − w) the inside of the unit circle becomes the half plane Re w < 0, and q of degree k

    p(w) = (1 − w)^k q(s) = Σ_j q_j (1 + w)^j (1 − w)^(k−j),    leading coefficient (−1)^k q(−1),  p(1) = 2^k

All roots of a monic q are inside exactly if (−1)^k q(−1) is positive and p is Hurwitz. An irreducible q of
degree 2 or more has p irreducible of the same degree; a root on the circle is one of p on the imaginary axis.
A root 0 is gone after as many steps as its multiplicity.

References
----------
E. I. Jury, Theory and Application of the z-Transform Method (1964), ch. 3 (the same by determinants).
"""

from __future__ import annotations

from math import comb
from typing import TYPE_CHECKING, Final

from obscli.exact.hurwitz import (
    MOST_CONDITIONS,
    Stability,
    balls_of_roots,
    has_parameters,
    hurwitz_determinants,
    positive,
    sign,
    stability,
)
from obscli.exact.spectrum import Factor


if TYPE_CHECKING:
    from collections.abc import Sequence

    from obscli.exact.field import Element
    from obscli.exact.prove import Proof
    from obscli.exact.structure_finding import ModeKind

_NEUTRAL: Final = Stability("neutral", never=True)


def schur_stability(proof: Proof, factor: Factor) -> Stability:
    """Return how the modes of an irreducible factor go on from step to step."""
    q = factor.coefficients
    if factor.degree == 1:
        return _of_line(proof, q[0])
    p = in_half_plane(q)
    if not p[-1]:  # a root −1: of a polynomial that counts as one factor because of its roots
        return Stability("depends" if has_parameters(proof, q) else "undecided", never=True)
    monic = Factor(tuple(c / p[-1] for c in p), factor.multiplicity)
    known = stability(proof, monic)
    if known.kind != "depends" or known.never:
        return known
    # signs are told of products: the scale of p matters to none where its leading coefficient is positive
    k = factor.degree
    determinants = hurwitz_determinants(proof, monic.coefficients)
    scaled = [minor * p[-1] ** (i + 1) for i, minor in enumerate(determinants)]
    needed = [p[-1], *scaled, p[0]]
    open_ones = [one for one in needed if sign(proof, one) is None]
    if len(open_ones) > MOST_CONDITIONS:
        return Stability("depends", f"all {k} roots of its polynomial lie inside the unit circle")
    return Stability("depends", " and ".join(dict.fromkeys(positive(proof, one) for one in open_ones)))


def _of_line(proof: Proof, q0: Element) -> Stability:
    """Judge the root s = −q0 by the sign of 1 − s²."""
    inside = proof.exact.field.one - q0 * q0
    match sign(proof, inside):
        case 1:
            return Stability("decaying")
        case 0:
            return _NEUTRAL
        case -1:
            return Stability("growing", never=True)
    if not has_parameters(proof, [q0]):
        return Stability("undecided")
    return Stability("depends", positive(proof, inside))


def in_half_plane(q: Sequence[Element]) -> list[Element]:
    """Return p(w) = (1 − w)^k q((1 + w)/(1 − w)) by rising degree."""
    k, field = len(q) - 1, q[-1].field
    found = [field.zero] * (k + 1)
    for j, coefficient in enumerate(q):
        for a in range(j + 1):
            for b in range(k - j + 1):
                number = comb(j, a) * comb(k - j, b) * (-1) ** b
                found[a + b] = found[a + b] + coefficient * field.rational(number)
    return found


def roots_inside(proof: Proof, factor: Factor) -> tuple[tuple[complex, ...], ModeKind]:
    """Return the roots of a factor at the file's values, and how its modes go on there, by enclosures.

    No roots where a value is missing; undecided where an enclosure does not tell a modulus from 1.
    """
    found = balls_of_roots(proof, factor.coefficients)
    values = tuple(complex(float(real.mid()), float(imag.mid())) for real, imag in found)
    beyond = [real * real + imag * imag - 1 for real, imag in found]
    if any(one > 0 for one in beyond):
        return values, "growing"
    if beyond and all(one < 0 for one in beyond):
        return values, "decaying"
    return values, "neutral" if beyond and all(one < 0 or one.is_zero() for one in beyond) else "undecided"
