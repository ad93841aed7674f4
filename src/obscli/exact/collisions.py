"""Where generators that vary in time become dependent: rates that vanish, harmonics that coincide.

For base angles θ_j(t) a divisor is a trigonometric polynomial Σ c_k exp(i k·θ). It can vanish identically
though no content does only if two harmonics k ≠ k' that occur in it coincide: (k - k')·θ' = 0 for all t.
The content in time of (k - k')·θ' gives the hypersurfaces. Exponentials likewise. Logarithms and arcus
tangents log u, atan v become dependent only where factors of u, 1 + v² coincide: a resultant vanishes.
Constants are the matter of ``entangled``.
"""

from __future__ import annotations

from itertools import combinations, product
from math import gcd, prod
from typing import TYPE_CHECKING, TypeAlias

from flint import Ordering, nmod_mpoly_ctx

from obscli.exact.angles import LARGEST_MULTIPLE
from obscli.exact.candidates import Candidate, content_candidates
from obscli.exact.entangled import entangled_constants
from obscli.exact.field import Element
from obscli.exact.polynomial import MOST_PAIRS, require_small
from obscli.model.notation import to_text


if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from obscli.exact.exact_system import ExactSystem
    from obscli.exact.field import Generator
    from obscli.exact.polynomial import Polynomial

#: A prime with p = 1 (mod 4), so that i = √-1 exists, and that root.
_PRIME = 2305843009213693921
Harmonic: TypeAlias = tuple[int, ...]

#: Resultants of polynomials with a larger product of degrees and terms are not computed.
_LARGEST_RESULTANT = 2000

#: More differences of harmonics than this are not all tried; the report says so.
MOST_DIFFERENCES = 400


def collision_candidates(
    exact: ExactSystem, divisors: Sequence[Polynomial]
) -> tuple[dict[str, Candidate], tuple[str, ...]]:
    """Return the hypersurfaces on which varying generators become dependent, and what was not tried."""
    found: dict[str, Candidate] = {}
    left_out: list[str] = []
    field = exact.field
    ruled = [
        field.derivative(k)
        for k, g in enumerate(field.generators)
        if g.kind == "function" and field.varies(k)
    ]
    found.update(content_candidates(exact, [rate.num for rate in ruled], "collision"))
    if any(_has_parameters(exact, rate) for rate in ruled):
        left_out.append("parameter values at which functions given by a rule become dependent")
    if _has_powers(exact):
        left_out.append("exponents at which a power such as u^a becomes algebraic")
    if exact.interpreter.kept_apart:
        left_out.append(
            f"relations between harmonics more than {LARGEST_MULTIPLE}-fold multiples of each other"
        )
    entangled = entangled_constants(exact)
    if entangled:
        names = ", ".join(_constant(field.generators[k]) for k in entangled[:3])
        left_out.append(f"values at which {names} is related in another way to the rest of the model")
        found.update(content_candidates(exact, _special_arguments(exact, entangled), "collision"))
    resultants, skipped = _common_factors(exact)
    found.update(content_candidates(exact, resultants, "collision"))
    left_out += skipped
    for kind in ("angle", "exponential", "primitive"):
        indices = [k for k, g in enumerate(field.generators) if g.kind == kind and field.varies(k)]
        if not indices:
            continue
        differences = _differences(exact, divisors, indices, kind)
        if len(differences) > MOST_DIFFERENCES:
            left_out.append(f"coincidences of more than {MOST_DIFFERENCES} pairs of harmonics")
            differences = sorted(differences, key=lambda k: sum(map(abs, k)))[:MOST_DIFFERENCES]
        rates = [_rate(exact, k) for k in indices]
        for difference in differences:
            combined = field.zero
            for factor, rate in zip(difference, rates, strict=True):
                combined = combined + field.rational(factor) * rate
            if combined:
                found.update(content_candidates(exact, [combined.num], "collision"))
    return found, tuple(left_out)


def _constant(generator: Generator) -> str:
    if generator.kind == "angle" and generator.argument is not None:
        return f"sin({to_text(generator.argument)})"
    return to_text(generator.meaning)


def _special_arguments(exact: ExactSystem, constants: Iterable[int]) -> Iterable[Polynomial]:
    """Yield what vanishes where a constant has the value of an exact number: sin 0 = 0, log 1 = 0."""
    for k in constants:
        generator = exact.field.generators[k]
        assert generator.argument is not None
        element = exact.interpreter.read(generator.argument)
        yield element.num - element.den if generator.function == "log" else element.num


def _common_factors(exact: ExactSystem) -> tuple[list[Polynomial], list[str]]:
    """Return resultants that vanish where arguments of varying primitives share a factor; what is left."""
    field = exact.field
    primitives = [k for k, g in enumerate(field.generators) if g.kind == "primitive" and field.varies(k)]
    if len(primitives) < 2:
        return [], []
    arguments = [_critical_points(exact, k) for k in primitives]
    resultants = []
    small = all(field.generators[k].function != "asin" for k in primitives)
    for mine, other in combinations(arguments, 2):
        for a, b in product(mine, other):
            for k, degrees in enumerate(zip(a.degrees(), b.degrees(), strict=True)):
                if min(degrees) <= 0 or not field.varies(k):
                    continue
                if degrees[0] * degrees[1] * len(a) * len(b) > _LARGEST_RESULTANT:
                    small = False
                    continue
                resultant = a.resultant(b, k)
                if not resultant.is_zero():
                    resultants.append(resultant)
    return resultants, [] if small else ["coincidences among logarithms and inverse functions"]


def _critical_points(exact: ExactSystem, k: int) -> list[Polynomial]:
    """Return the polynomials at whose zeros the primitive (log u, atan u) is singular."""
    generator = exact.field.generators[k]
    assert generator.argument is not None
    u = exact.interpreter.read(generator.argument)
    parts = [u.num, u.den] if generator.function == "log" else [u.num * u.num + u.den * u.den]
    return [exact.field.norm(part) for part in parts if not part.is_constant()]


def _has_powers(exact: ExactSystem) -> bool:
    """Whether an exponent or angle contains a logarithm or inverse function: exp(a log u), sin(a atan u)."""
    primitives = [k for k, g in enumerate(exact.field.generators) if g.kind == "primitive"]
    return any(
        exact.interpreter.read(g.argument).num.degrees()[k] > 0
        for g in exact.field.generators
        if g.kind in {"angle", "exponential"} and g.argument is not None
        for k in primitives
    )


def _has_parameters(exact: ExactSystem, element: Element) -> bool:
    degrees = zip(element.num.degrees(), element.den.degrees(), strict=True)
    return any(
        max(pair) > 0 and exact.field.generators[k].kind == "parameter" for k, pair in enumerate(degrees)
    )


def _rate(exact: ExactSystem, k: int) -> Element:
    """Return the derivative of the angle, exponent or primitive behind a generator."""
    generator = exact.field.generators[k]
    if generator.kind == "primitive" or generator.argument is None:
        return exact.field.derivative(k)
    return exact.field.derive(exact.interpreter.read(generator.argument))


def _differences(
    exact: ExactSystem, divisors: Sequence[Polynomial], indices: Sequence[int], kind: str
) -> list[Harmonic]:
    units = [tuple(int(i == j) for j in range(len(indices))) for i in range(len(indices))]
    found = set(units)
    if len(indices) == 1:
        return list(found)
    for divisor in divisors:
        norm = exact.field.norm(divisor)
        require_small(len(norm) * prod(int(norm.degrees()[k]) + 1 for k in indices), MOST_PAIRS)
        harmonics = _harmonics(norm, indices) if kind == "angle" else _exponents(norm, indices)
        for a, b in combinations(harmonics, 2):
            found.add(_primitive(tuple(x - y for x, y in zip(a, b, strict=True))))
    if kind == "primitive":
        small = product(range(-2, 3), repeat=len(indices)) if len(indices) <= 3 else units
        found |= {_primitive(k) for k in small if any(k)}
    return sorted(found)


def _primitive(k: Harmonic) -> Harmonic:
    common = gcd(*k)
    first = next((x for x in k if x), 1)
    sign = 1 if first > 0 else -1
    return tuple(sign * x // common for x in k)


def _exponents(polynomial: Polynomial, indices: Sequence[int]) -> set[Harmonic]:
    return {tuple(int(exponents[k]) for k in indices) for exponents in polynomial.monoms()}


def _harmonics(polynomial: Polynomial, indices: Sequence[int]) -> Iterable[Harmonic]:
    """Return the harmonics of a polynomial in half-angle tangents: τ = -i (z - 1)/(z + 1), z = exp(iθ).

    The other generators take fixed values modulo a prime; a harmonic lost by accident is lost with
    probability of about 2^-61.
    """
    ctx = nmod_mpoly_ctx.get([f"z{k}" for k in indices], _PRIME, Ordering.lex)  # type: ignore[call-arg, arg-type]
    tops = [int(polynomial.degrees()[k]) for k in indices]
    i = pow(_non_residue(), (_PRIME - 1) // 4, _PRIME)
    total = ctx.constant(0)
    for exponents, coefficient in polynomial.terms():
        value = int(coefficient) % _PRIME
        for k, e in enumerate(exponents):
            if e and k not in indices:
                value = value * pow(7919 + 104729 * k, int(e), _PRIME) % _PRIME
        term = ctx.constant(value)
        for z, k, top in zip(ctx.gens(), indices, tops, strict=True):
            e = int(exponents[k])
            term = term * ((z - 1) * (_PRIME - i)) ** e * (z + 1) ** (top - e)
        total = total + term
    return {tuple(int(e) for e in exponents) for exponents in total.monoms()}


def _non_residue() -> int:
    return next(a for a in range(2, 100) if pow(a, (_PRIME - 1) // 2, _PRIME) == _PRIME - 1)
