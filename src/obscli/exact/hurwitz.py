"""Whether the roots of a polynomial over the constants have negative real parts, exactly.

All roots of q(s) = s^k + q_{k-1} s^{k-1} + … + q_0 have negative real parts exactly if the Hurwitz
determinants Δ_1 … Δ_{k−1} and q_0 are positive, Δ_i the leading minors of

    h_ij = q_{k−2j+i}      i, j = 1 … k          (Δ_k = q_0 Δ_{k−1})

An irreducible q has a root on the imaginary axis only if q(s) = ±q(−s): q = s, or q(s) = p(s²), and then
all of its roots lie there exactly if the roots of p are real and negative.

References
----------
F. R. Gantmacher, The Theory of Matrices II (1959), ch. XV.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import lcm
from typing import TYPE_CHECKING, Final, Literal, cast

from flint import acb, acb_poly, arb, fmpz_poly

from obscli.exact.ball import BallPoint, OutsideDomainError, precision
from obscli.exact.field import Element
from obscli.exact.polynomial import factored, times
from obscli.exact.roots import evident_sign, sign_of
from obscli.exact.there import balls_there
from obscli.model.expression import symbols
from obscli.model.notation import to_text


if TYPE_CHECKING:
    from collections.abc import Sequence

    from obscli.exact.prove import Proof
    from obscli.exact.spectrum import Factor
    from obscli.exact.structure_finding import ModeKind

#: More determinants than this are not written as conditions.
MOST_CONDITIONS: Final = 4
_BITS: Final = (128, 512, 2000)
_TOLERANCE: Final = arb(2) ** -60


@dataclass(frozen=True, slots=True)
class Stability:
    """How the modes of one factor go on.

    ``condition``: what makes them decay, where that depends on parameters; ``never``: nothing does, whether
    they stay or grow.
    """

    kind: ModeKind
    condition: str = ""
    never: bool = False


def stability(proof: Proof, factor: Factor) -> Stability:
    """Return how the modes of an irreducible factor go on."""
    q = factor.coefficients
    if factor.degree == 1:
        return _of_line(proof, q[0])
    if not any(q[k] for k in range(factor.degree - 1, -1, -2)):
        return _of_even(proof, q)
    signs = [(minor, sign(proof, minor)) for minor in (*hurwitz_determinants(proof, q), q[0])]
    if all(one == 1 for _, one in signs):
        return Stability("decaying")
    if any(one in {0, -1} for _, one in signs):
        return _not_decaying(proof, q)
    if not has_parameters(proof, q):
        return Stability("undecided")
    open_minors = [minor for minor, one in signs if one is None]
    if len(open_minors) > MOST_CONDITIONS:
        return Stability("depends", "all Hurwitz determinants of its polynomial are positive")
    conditions = dict.fromkeys(positive(proof, minor) for minor in open_minors)
    return Stability("depends", " and ".join(conditions))


def _of_line(proof: Proof, q0: Element) -> Stability:
    """Judge the root −q0."""
    match sign(proof, q0):
        case 1:
            return Stability("decaying")
        case 0:
            return Stability("neutral", never=True)
        case -1:
            return Stability("growing", never=True)
    if not has_parameters(proof, [q0]):
        return Stability("undecided")
    return Stability("depends", positive(proof, q0))


def _of_even(proof: Proof, q: Sequence[Element]) -> Stability:
    """Judge q(s) = p(s²): its roots come in pairs s, −s, so nothing makes all of them decay."""
    if len(q) == 3:
        known = sign(proof, q[0])
        if known is not None:
            return Stability("neutral" if known > 0 else "growing", never=True)
    rational = _rational(q[::2])
    if rational is None:
        return Stability("depends" if has_parameters(proof, q) else _by_roots(proof, q), never=True)
    squares = [root for root, _ in cast("list[tuple[acb, int]]", fmpz_poly(rational).complex_roots())]
    on_axis = all(root.imag.is_zero() and root.real < 0 for root in squares)
    return Stability("neutral" if on_axis else "growing", never=True)


def _not_decaying(proof: Proof, q: Sequence[Element]) -> Stability:
    """Judge a polynomial that is not even and whose determinants are not all positive: a root grows.

    Irreducible, it has no root on the imaginary axis; that is known of rational coefficients only.
    """
    known = _rational(q) is not None or len(q) == 3
    return Stability("growing" if known else _by_roots(proof, q), never=True)


def _by_roots(proof: Proof, q: Sequence[Element]) -> ModeKind:
    if has_parameters(proof, q):
        return "depends"
    return "growing" if any(real > 0 for real, _ in balls_of_roots(proof, q)) else "undecided"


def hurwitz_determinants(proof: Proof, q: Sequence[Element]) -> list[Element]:
    """Return Δ_1 … Δ_{k−1} of a monic polynomial given by rising degree."""
    k, field = len(q) - 1, proof.exact.field

    def entry(i: int, j: int) -> Element:
        return q[k - 2 * j + i] if 0 <= k - 2 * j + i <= k else field.zero

    matrix = [[entry(i, j) for j in range(1, k)] for i in range(1, k)]
    return [_determinant(field.one, field.zero, [row[:i] for row in matrix[:i]]) for i in range(1, k)]


def _determinant(one: Element, zero: Element, rows: list[list[Element]]) -> Element:
    """Return a determinant by elimination."""
    rows = [list(row) for row in rows]
    total = one
    for k in range(len(rows)):
        pivot = next((i for i in range(k, len(rows)) if rows[i][k]), None)
        if pivot is None:
            return zero
        if pivot != k:
            rows[k], rows[pivot], total = rows[pivot], rows[k], -total
        total = total * rows[k][k]
        for i in range(k + 1, len(rows)):
            if rows[i][k]:
                ratio = rows[i][k] / rows[k][k]
                rows[i] = [a - ratio * b for a, b in zip(rows[i], rows[k], strict=True)]
    return total


def sign(proof: Proof, element: Element) -> Literal[-1, 0, 1] | None:
    """Return the sign of a constant: exactly, by what is positive, or by its ball; None: not known."""
    if not element:
        return 0
    evident = sign_of(proof.exact.interpreter, times(element.num, element.den))
    if evident is not None:
        return 1 if evident > 0 else -1
    return None if has_parameters(proof, [element]) else _ball_sign(proof, element)


def _ball_sign(proof: Proof, element: Element) -> Literal[-1, 1] | None:
    interpreter = proof.exact.interpreter
    expression = interpreter.element_expression(element)
    for bits in _BITS:
        with precision(bits, 1):
            try:
                ball = BallPoint(interpreter.system, {}, 1, interpreter.definitions).value(expression)[0]
            except OutsideDomainError:
                continue
            if ball > 0:
                return 1
            if ball < 0:
                return -1
    return None


def has_parameters(proof: Proof, elements: Sequence[Element]) -> bool:
    """Whether parameters occur in constants."""
    interpreter = proof.exact.interpreter
    return bool(symbols(*(interpreter.element_expression(e) for e in elements if e)))


def _rational(q: Sequence[Element]) -> list[int] | None:
    """Return a polynomial with rational coefficients times their common denominator, else None."""
    values = [value for c in q if (value := c.rational) is not None]
    if len(values) < len(q):
        return None
    scale = lcm(*(value.denominator for value in values))
    return [int(value * scale) for value in values]


def positive(proof: Proof, element: Element) -> str:
    """Return ``element > 0`` in its simplest form: without squares and without factors of known sign."""
    interpreter = proof.exact.interpreter
    constant, factors = factored(times(element.num, element.den))
    flipped = constant < 0
    rest = []
    for factor, exponent in factors:
        known = evident_sign(interpreter, factor)
        if exponent % 2 and known is None:
            rest.append(factor)
        elif exponent % 2 and known == -1:
            flipped = not flipped
    product = proof.exact.field.one_polynomial
    for factor in rest:
        product = times(product, factor)
    if product.leading_coefficient() < 0:
        product, flipped = -product, not flipped
    kept = Element(proof.exact.field, product, proof.exact.field.one_polynomial)
    return f"{to_text(proof.restorer.element(kept))} {'<' if flipped else '>'} 0"


def roots_there(proof: Proof, factor: Factor) -> tuple[tuple[complex, ...], ModeKind]:
    """Return the roots of a factor at the file's values, and how its modes go on there, by enclosures.

    No roots where a value is missing; undecided where an enclosure does not tell a real part from zero.
    """
    found = balls_of_roots(proof, factor.coefficients)
    values = tuple(complex(float(real.mid()), float(imag.mid())) for real, imag in found)
    reals = [real for real, _ in found]
    if any(real > 0 for real in reals):
        return values, "growing"
    if reals and all(real < 0 for real in reals):
        return values, "decaying"
    return values, "neutral" if reals and all(real < 0 or real.is_zero() for real in reals) else "undecided"


def balls_of_roots(proof: Proof, q: Sequence[Element]) -> list[tuple[arb, arb]]:
    """Return enclosures of the roots of a polynomial at the file's values, none where they are not found."""
    with precision(_BITS[1], 1):
        balls = balls_there(proof.exact.interpreter, q)
        try:
            roots = [] if balls is None else acb_poly(balls).roots(tol=_TOLERANCE)
        except ValueError:
            return []
    return [(root.real, root.imag) for root in roots]
