"""Parameter values and identities among functions at which the rank drops.

Complete in codimension one for parameters: every real hypersurface of parameter space on which the
generic-in-t rank drops is a zero of a divisor's content, a collision of generators, or a half-angle at
infinity (see ``candidates``, ``collisions``). Each candidate is screened modulo a prime on the hypersurface
(a full rank there is proof that it is not critical), and what remains is confirmed by an exact, proved
rerun on the specialised system.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from obscli.exact.candidates import (
    Candidate,
    allowed_by_assumptions,
    content_candidates,
    has_real_zeros,
    value_allowed,
)
from obscli.exact.collisions import collision_candidates
from obscli.exact.entangled import entangled_constants
from obscli.exact.errors import UndecidedError, UndefinedError
from obscli.exact.finding import CriticalSearch, CriticalValue
from obscli.exact.identities import search_identities
from obscli.exact.instants import search_instants
from obscli.exact.rerun import rerun
from obscli.exact.screen import full_rank_on
from obscli.exact.solve import Solution, points_at_infinity, proved_definite, solve, takes_both_signs
from obscli.exact.tidy import merge_opposite_angles
from obscli.model.expression import Expression, symbols
from obscli.model.notation import to_text


if TYPE_CHECKING:
    from obscli.exact.polynomial import Polynomial
    from obscli.exact.prove import Proof


@dataclass(slots=True)
class _Search:
    proof: Proof
    values: list[CriticalValue]
    complete: bool
    confirms: bool = True


def search_critical_values(proof: Proof, progress: Callable[[str], None]) -> CriticalSearch:
    """Search parameter values, identities among functions and instants at which the rank drops."""
    search, left_out = _search(_Search(proof, [], complete=True), progress)
    identities, unsearched = search_identities(proof, progress)
    values = (*merge_opposite_angles(search.values), *identities)
    not_searched = (*left_out, *unsearched, *_codimension(proof))
    instants = search_instants(proof)
    return CriticalSearch(values, search.complete and not left_out, not_searched, instants)


def search_candidates(proof: Proof, progress: Callable[[str], None]) -> CriticalSearch:
    """Search parameter values at which the rank may drop, without the proof on the specialised system.

    What passes the screen is of the kind "candidate": for somebody who confirms it for a larger system.
    """
    search, left_out = _search(_Search(proof, [], complete=True, confirms=False), progress)
    jets = any(g.kind == "jet" for g in proof.exact.field.generators)
    functions = ("identities among functions",) if jets else ()
    values = tuple(merge_opposite_angles(search.values))
    return CriticalSearch(
        values, search.complete and not left_out, (*left_out, *functions, *_codimension(proof)), ()
    )


def _search(search: _Search, progress: Callable[[str], None]) -> tuple[_Search, tuple[str, ...]]:
    """Try every candidate; return what was found and what was left out."""
    proof = search.proof
    candidates, left_out = _candidates(proof)
    for candidate in candidates:
        progress(f"critical values: {_condition(proof, candidate.polynomial)}")
        _try(search, candidate)
    for condition, solution in points_at_infinity(proof.exact.interpreter):
        if solution is None:
            _leave_open(search, condition, "it could not be solved for a parameter")
        else:
            _confirm(search, solution, allowed=True)
    return search, left_out


def _candidates(proof: Proof) -> tuple[list[Candidate], tuple[str, ...]]:
    exact, divisors = proof.exact, proof.flag.divisors
    collisions, left_out = collision_candidates(exact, divisors)
    merged = {
        **content_candidates(exact, divisors, "divisor"),
        **collisions,
        **content_candidates(exact, _denominators(proof), "denominator"),
    }
    return [c for c in merged.values() if has_real_zeros(exact, c.polynomial)], left_out


def _denominators(proof: Proof) -> Iterable[Polynomial]:
    exact = proof.exact
    return {str(e.den): e.den for row in (*exact.A, *exact.H) for e in row.values()}.values()


def _try(search: _Search, candidate: Candidate) -> None:
    proof, polynomial = search.proof, candidate.polynomial
    interpreter = proof.exact.interpreter
    if candidate.origin == "denominator":
        solutions = solve(interpreter, polynomial)
        search.values += [_undefined(s.condition, s.equation) for s in solutions]
        if not solutions:
            expression = proof.restorer.polynomial(polynomial)
            search.values.append(_undefined(_condition(proof, polynomial), expression))
        return
    if _keeps_generators(proof, candidate) and full_rank_on(proof.exact, polynomial, proof.saturation):
        return
    if not takes_both_signs(interpreter, polynomial) and len(polynomial) > 1:
        if not proved_definite(interpreter, polynomial):
            _leave_open(search, _condition(proof, polynomial), "it is not known whether it has real zeros")
        return
    solutions = solve(interpreter, polynomial)
    if not solutions:
        _leave_open(search, _condition(proof, polynomial), "it could not be solved for a parameter")
    allowed = allowed_by_assumptions(proof.exact, polynomial)
    for solution in solutions:
        _confirm(search, solution, allowed=allowed)


def _keeps_generators(proof: Proof, candidate: Candidate) -> bool:
    """Whether the generators stay independent on the hypersurface, so that the screen is conclusive.

    They may not where a parameter in the polynomial occurs in the argument of an angle, an exponent, a
    primitive or a root as well (on phi = 0 the tangent of phi/2 is 0), nor where a constant in it has no
    parameter of its own (on tan(phi/2) = 1 phi itself is pi/2).
    """
    if candidate.origin == "collision":
        return False
    generators = proof.exact.field.generators
    if any(candidate.polynomial.degrees()[k] > 0 for k in entangled_constants(proof.exact)):
        return False
    named = {
        generators[k].name
        for k, degree in enumerate(candidate.polynomial.degrees())
        if degree > 0 and generators[k].kind == "parameter"
    }
    arguments = [g.argument for g in generators if g.argument is not None]
    arguments += [coefficient for g in generators if g.kind == "root" for coefficient in g.relation]
    return not named & symbols(*arguments)


def _confirm(search: _Search, solution: Solution, *, allowed: bool) -> None:
    condition = solution.condition
    allowed = allowed and value_allowed(search.proof.exact, solution.name, solution.value)
    values = ({solution.name: solution.value},)
    if not search.confirms:
        kind = "candidate" if allowed else "excluded"
        search.values.append(
            CriticalValue(condition, kind, None, (), zero=solution.equation, values=values)  # type: ignore[arg-type]
        )
        return
    try:
        result = rerun(search.proof, {solution.name: solution.value})
    except UndefinedError:
        search.values.append(_undefined(condition, solution.equation))
        return
    except UndecidedError as error:
        _leave_open(search, condition, str(error))
        return
    if result is None:
        return
    search.values.append(
        CriticalValue(
            condition,
            "confirmed" if allowed else "excluded",
            result.rank,
            result.lost,
            "" if allowed else "outside what the file assumes",
            zero=solution.equation,
            values=values,
        )
    )


def _undefined(condition: str, zero: Expression) -> CriticalValue:
    return CriticalValue(condition, "undefined", None, (), "A or H does not exist there", zero=zero)


def _leave_open(search: _Search, condition: str, reason: str) -> None:
    search.values.append(CriticalValue(condition, "undecided", None, (), reason))
    search.complete = False


def _condition(proof: Proof, polynomial: Polynomial) -> str:
    return f"{to_text(proof.restorer.polynomial(polynomial))} = 0"


def _codimension(proof: Proof) -> tuple[str, ...]:
    if sum(g.kind == "parameter" for g in proof.exact.field.generators) < 2:
        return ()
    return ("combinations of two or more conditions on parameters (codimension two and higher)",)
