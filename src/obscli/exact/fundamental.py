"""A basis of the solutions of μ(d/dt) f = 0 in readable form, each with its derivatives at 0.

An irreducible factor q of μ, of multiplicity m, gives t^k φ, k < m, with φ one of

    q = s − λ                        e^{λt}
    q = s² + b s + c                 e^{σt} cos ωt,  e^{σt} sin(ωt)/ω      σ = −b/2,  ω² = c − b²/4
                                     (cosh, sinh of √(−ω²) t where ω² < 0)
    q of degree ≥ 3                  φ_0 … φ_{k−1},  q(d/dt) φ_i = 0,  φ_i^(j)(0) = δ_ij

All derivatives at 0 are in the field of the coefficients, though ω or the roots of q need not be:

    φ^(n+k)(0) = −Σ_j q_j φ^(n+j)(0),     (t^k φ)^(n)(0) = n!/(n−k)! φ^(n−k)(0)
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import perm
from typing import TYPE_CHECKING, Final, Literal

from obscli.exact.ball import precision
from obscli.exact.echelon import polynomial_row, reduced_echelon
from obscli.exact.eigenvalue_text import square_root
from obscli.exact.field import Element
from obscli.exact.hurwitz import sign
from obscli.exact.relation_terms import names_in
from obscli.exact.relations_finding import Canonical
from obscli.exact.rows import field_row
from obscli.exact.there import balls_there
from obscli.model.expression import ONE, Apply, Symbol, divide, multiply, power
from obscli.model.notation import to_text


if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from obscli.exact.exact_system import Row
    from obscli.exact.field import Field
    from obscli.exact.prove import Proof
    from obscli.exact.spectrum import Factor
    from obscli.model.expression import Expression

_HALF: Final = Fraction(1, 2)
_BITS: Final = 512


@dataclass(frozen=True, slots=True, eq=False)
class Fundamental:
    """One function and its derivatives at 0: f(0), f'(0), and so on."""

    expression: Expression
    derivatives: tuple[Element, ...]


@dataclass(frozen=True, slots=True, eq=False)
class FundamentalSystem:
    """The functions of all factors, what their names mean, and on what their form rests."""

    functions: tuple[Fundamental, ...]
    canonical: tuple[Canonical, ...]
    notes: tuple[str, ...]


def fundamental_system(proof: Proof, factors: Sequence[Factor]) -> FundamentalSystem:
    """Return as many functions as the factors have roots, each with as many derivatives."""
    length = sum(factor.degree * factor.multiplicity for factor in factors)
    functions: list[Fundamental] = []
    canonical: list[Canonical] = []
    notes: list[str] = []
    for factor in factors:
        if factor.degree == 1:
            forms = [_exponential(proof, -factor.coefficients[0])]
        elif factor.degree == 2:
            forms, note = _oscillation(proof, factor)
            notes += note
        else:
            canonical.append(_canonical(proof, factor, len(canonical)))
            forms = [Symbol(name) for name in canonical[-1].names]
        functions += _with_powers(proof, factor, forms, length)
    return FundamentalSystem(tuple(functions), tuple(canonical), tuple(notes))


def inverse_at_zero(field: Field, functions: Sequence[Fundamental]) -> list[Row]:
    """Return the inverse of the matrix with the k-th derivatives at 0 in its k-th row; fewer rows: none."""
    d = len(functions)
    rows = []
    for k in range(d):
        row = {j: one.derivatives[k] for j, one in enumerate(functions) if one.derivatives[k]}
        rows.append(polynomial_row(field, {**row, d + k: field.one}))
    inverse: list[Row] = []
    for pivot, found in sorted(reduced_echelon(field, rows, range(2 * d)).items()):
        if pivot < d:
            lead = Element(field, found[pivot], field.one_polynomial)
            inverse.append({k - d: entry / lead for k, entry in field_row(field, found).items() if k >= d})
    return inverse


def _with_powers(
    proof: Proof, factor: Factor, forms: Sequence[Expression], length: int
) -> Iterator[Fundamental]:
    """Yield t^k φ, k < m, for each φ."""
    field, time = proof.exact.field, Symbol(proof.exact.system.time)
    known = [_derivatives(proof, factor, start, length) for start in _starts(proof, factor)]
    for k in range(factor.multiplicity):
        for form, base in zip(forms, known, strict=True):
            shifted = (
                field.rational(perm(n, k)) * base[n - k] if n >= k else field.zero for n in range(length)
            )
            yield Fundamental(multiply(power(time, k), form), tuple(shifted))


def _starts(proof: Proof, factor: Factor) -> list[list[Element]]:
    """Return φ(0), φ'(0), … φ^(k−1)(0) of each φ: e^{σt} cos ωt begins with 1, σ; all others with δ_ij."""
    field = proof.exact.field
    starts = [[field.zero] * factor.degree for _ in range(factor.degree)]
    for i, start in enumerate(starts):
        start[i] = field.one
    if factor.degree == 2:
        starts[0][1] = -factor.coefficients[1] * field.rational(_HALF)
    return starts


def _derivatives(proof: Proof, factor: Factor, start: Sequence[Element], length: int) -> list[Element]:
    known, k = list(start), factor.degree
    for n in range(length - k):
        total = proof.exact.field.zero
        for j, coefficient in enumerate(factor.coefficients[:-1]):
            total = total - coefficient * known[n + j]
        known.append(total)
    return known


def _exponential(proof: Proof, rate: Element) -> Expression:
    """Return e^{λt}, 1 for λ = 0."""
    if not rate:
        return ONE
    return Apply("exp", multiply(proof.restorer.element(rate), Symbol(proof.exact.system.time)))


def _oscillation(proof: Proof, factor: Factor) -> tuple[list[Expression], list[str]]:
    """Return both solutions of a factor of degree two, and a remark where ω² may have either sign."""
    field, time = proof.exact.field, Symbol(proof.exact.system.time)
    half = factor.coefficients[1] * field.rational(_HALF)
    square = factor.coefficients[0] - half * half
    known = sign(proof, square)
    turns = known if known is not None else _sign_there(proof, square)
    envelope = _exponential(proof, -half)
    if known == 0:  # a perfect square that algebraic numbers kept from being seen as one
        return [envelope, multiply(time, envelope)], []
    names = ("cosh", "sinh") if turns == -1 else ("cos", "sin")
    rate = square_root(proof, -square if turns == -1 else square)
    even, odd = (Apply(name, multiply(rate, time)) for name in names)
    note = [] if known is not None else [_either_sign(proof, square, turns)]
    return [multiply(envelope, even), multiply(envelope, divide(odd, rate))], note


def _either_sign(proof: Proof, square: Element, turns: Literal[-1, 0, 1] | None) -> str:
    there = {-1: "< 0, as at the file's values", 1: "> 0, as at the file's values", None: "> 0", 0: "> 0"}
    first, second = ("cosh, sinh", "cos, sin") if turns == -1 else ("cos, sin", "cosh, sinh")
    quantity = to_text(proof.restorer.element(square))
    return f"{first} where {quantity} {there[turns]}; where it has the other sign they are {second}"


def _sign_there(proof: Proof, element: Element) -> Literal[-1, 1] | None:
    """Return the sign of a constant at the file's values; None: a value is missing, or it is zero."""
    with precision(_BITS, 1):
        balls = balls_there(proof.exact.interpreter, [element])
    if balls is None:
        return None
    [ball] = balls
    return 1 if ball > 0 else -1 if ball < 0 else None


def _canonical(proof: Proof, factor: Factor, before: int) -> Canonical:
    """Name the canonical solutions of a factor, by names that nothing in the system has."""
    taken = names_in(proof.exact.system)
    stem = "phi" if not before else f"phi{before + 1}"
    while any(f"{stem}_{i}" in taken for i in range(factor.degree)):
        stem += "_"
    names = tuple(f"{stem}_{i}" for i in range(factor.degree))
    return Canonical(names, tuple(proof.restorer.element(c) for c in factor.coefficients))
