"""Isolated instants at which the observability matrix loses rank: a note, never a loss on an interval.

Candidates are the zeros in time of the divisors of the elimination. Most are spurious (a pivot vanishes,
another takes its place), so each is tried: rank of L_0 … L_{n-1} at a random point of the zero set modulo
a prime. (A = 0, H = [1, t²] has rank 1 at t = 0 and rank 2 on every interval.)
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from obscli.exact.errors import UndecidedError
from obscli.exact.polynomial import factored
from obscli.exact.roots import evident_sign
from obscli.exact.saturation import rank_at_instant, stays_independent
from obscli.exact.screen import points_on
from obscli.model.notation import to_text


if TYPE_CHECKING:
    from obscli.exact.polynomial import Polynomial
    from obscli.exact.prove import Proof

_MOST_FACTORS = 40
#: A factor of more terms than this is no condition that a reader could use.
_MOST_TERMS = 30
_KINDS = frozenset({"time", "angle", "exponential", "parameter", "pi"})


def search_instants(proof: Proof) -> tuple[str, ...]:
    """Return conditions on time, as text, at which the observability matrix loses rank."""
    if not proof.exact.varies:
        return ()
    found: list[Polynomial] = []
    for factor in _factors(proof):
        chosen = next(iter(points_on(factor)), None)
        if chosen is None:
            continue
        try:
            lost = not stays_independent(proof.exact, proof.saturation, chosen) and (
                rank_at_instant(proof.exact, proof.rank, chosen) < proof.rank
            )
        except UndecidedError:
            continue
        if lost:
            found.append(factor)
    return tuple(f"{to_text(proof.restorer.polynomial(p))} = 0" for p in _merged(proof, found))


def _merged(proof: Proof, factors: list[Polynomial]) -> list[Polynomial]:
    """Multiply factors in the same single angle: tan(θ/2) = ±1 are together cos θ = 0."""
    products: dict[object, Polynomial] = {}
    for number, factor in enumerate(factors):
        used = [k for k, degree in enumerate(factor.degrees()) if degree > 0]
        single = len(used) == 1 and proof.exact.field.generators[used[0]].kind == "angle"
        key = used[0] if single else ("apart", number)
        products[key] = products[key] * factor if key in products else factor
    return list(products.values())


def _factors(proof: Proof) -> list[Polynomial]:
    """Return irreducible factors of the divisors that vary in time and may vanish."""
    field = proof.exact.field
    found: dict[str, Polynomial] = {}
    for divisor in proof.flag.divisors:
        for factor, _ in factored(field.norm(divisor))[1]:
            used = [k for k, degree in enumerate(factor.degrees()) if degree > 0]
            kinds = {field.generators[k].kind for k in used}
            if len(factor) > _MOST_TERMS:
                continue
            if kinds <= _KINDS and any(field.varies(k) for k in used) and _may_vanish(proof, factor):
                found.setdefault(str(factor), factor)
    return list(found.values())[:_MOST_FACTORS]


def _may_vanish(proof: Proof, factor: Polynomial) -> bool:
    """Whether the factor is not of one evident sign: a single exponential, a sum of squares."""
    if len(factor) == 1:
        used = [k for k, degree in enumerate(factor.degrees()) if degree > 0]
        return not all(proof.exact.field.generators[k].kind == "exponential" for k in used)
    return evident_sign(proof.exact.interpreter, factor) is None
