"""Claims of a model file (``claims`` and ``expect``) checked exactly, and held against the Gramian.

The exact side decides. The Gramian confirms it, or contradicts it, which fails; where the exact side is
undecided the Gramian can refute, but not prove.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

from obscli.checks.agreement import verify_basis
from obscli.checks.counterexample import with_trajectories
from obscli.checks.exact_claim import Exact, ExactClaim, direction_text, text_of
from obscli.checks.witness import Testimony, Witness
from obscli.core.check import CheckResult
from obscli.core.place import Place
from obscli.core.verification import Verification
from obscli.exact.analysis import Options, analyze
from obscli.exact.errors import UndecidedError, UndefinedError
from obscli.exact.finding import Analysis, Undecided
from obscli.model.expression import Expression
from obscli.model.notation import to_text
from obscli.model.specialise import Specialisation, at_nominal
from obscli.model.system import Claim, Covector, Quantity, System
from obscli.numeric.analysis import Numeric
from obscli.numeric.errors import NotComputableError


#: Finds the Gramian of a system, or raises NotComputableError.
Look: TypeAlias = Callable[[System], Numeric]


@dataclass(frozen=True, slots=True, eq=False)
class Ground:
    """What a claim is compared with: the analysis at its values, how to get there, and the Gramian there."""

    analysis: Analysis | Undecided
    special: Specialisation
    witness: Witness | str


@dataclass(frozen=True, slots=True, eq=False)
class Assertion:
    """One thing a claim says, and how each side judges it; ``witness_decides``: what algebra leaves open."""

    text: str
    place: Place
    exact: Callable[[], Exact]
    witness: Callable[[Witness], Testimony]
    basis: tuple[Quantity, ...] | None = None
    witness_decides: bool = False


def check_claims(
    system: System, analysis: Analysis | Undecided, look: Look | None = None
) -> tuple[CheckResult, ...]:
    """Check every claim of a system, each part by itself, in the order of the file.

    Parameters
    ----------
    system : the system with its claims
    analysis : its proved analysis at generic values
    look : finds the Gramian of a system; None: exact algebra alone
    """
    grounds: dict[str, Ground] = {}
    results: list[CheckResult] = []
    for claim in system.claims:
        key = where_text(claim.at)
        if key not in grounds:
            grounds[key] = _ground(system, analysis, claim, look)
        results += check_claim(claim, grounds[key])
    return tuple(results)


def where_text(at: object) -> str:
    """Return the values at which something is claimed, in words; empty for generic ones."""
    if isinstance(at, Mapping):
        return ", ".join(f"{name} = {to_text(value)}" for name, value in at.items())
    return "the file's values" if at == "nominal" else ""


def _ground(system: System, generic: Analysis | Undecided, claim: Claim, look: Look | None) -> Ground:
    if claim.at is None:
        special = Specialisation(system, {})
        return Ground(generic, special, _witness(system, generic, look))
    special = at_nominal(system) if claim.at == "nominal" else Specialisation(system, _values(claim))
    there = special.system()
    analysis = analyze(there, Options(critical=False, certificate=False))
    return Ground(analysis, special, _witness(there, analysis, look))


def _values(claim: Claim) -> Mapping[str, Expression]:
    return claim.at if isinstance(claim.at, Mapping) else {}


def _witness(system: System, analysis: Analysis | Undecided, look: Look | None) -> Witness | str:
    """Return the Gramian at the values of the file, or why it says nothing about the claim."""
    if look is None:
        return ""
    if isinstance(analysis, Analysis) and analysis.at_values.rank not in (None, analysis.rank):
        return f"the Gramian is no witness: at the file's values the rank is {analysis.at_values.rank}"
    try:
        return Witness(look(system), analysis.rank if isinstance(analysis, Analysis) else None)
    except NotComputableError as error:
        return f"no Gramian: {error}"


def check_claim(claim: Claim, ground: Ground) -> Iterator[CheckResult]:
    """Check every part of one claim against its ground."""
    suffix = f" at {where}" if (where := where_text(claim.at)) else ""
    try:
        judge = (
            ExactClaim(claim, ground.analysis, ground.special)
            if isinstance(ground.analysis, Analysis)
            else None
        )
    except (UndecidedError, UndefinedError) as error:
        parts = _parts(claim)
        if len(parts) > 1:
            for part in parts:  # what cannot be read leaves the rest to be checked
                yield from check_claim(part, ground)
        else:
            yield CheckResult(f"claim{suffix}", "undecided", str(error), claim.place)
        return
    reason = ground.analysis.reason if isinstance(ground.analysis, Undecided) else ""
    for one in _assertions(claim, judge, ground.special, reason):
        found = _judged(one, suffix, ground.witness)
        if one.basis is not None and isinstance(ground.witness, Witness):
            found = replace(found, verification=_verified(one.basis, ground, found))
        yield found


def _parts(claim: Claim) -> list[Claim]:
    """Return a claim's parts as claims of their own."""
    empty = Claim(origin=claim.origin, place=claim.place, stage=claim.stage, at=claim.at)
    parts = [replace(empty, rank=claim.rank, rank_place=claim.rank_place)] if claim.rank is not None else []
    parts += [replace(empty, basis=claim.basis)] if claim.basis is not None else []
    parts += [replace(empty, observable=(q,)) for q in claim.observable]
    parts += [replace(empty, unobservable=(q,)) for q in claim.unobservable]
    parts += [replace(empty, directions=(q,)) for q in claim.directions]
    parts += [replace(empty, states=claim.states)] if claim.states else []
    parts += [replace(empty, detectable=claim.detectable)] if claim.detectable is not None else []
    return parts


def _assertions(
    claim: Claim, judge: ExactClaim | None, special: Specialisation, reason: str
) -> Iterator[Assertion]:
    """Yield what a claim says, part by part."""

    def one(
        text: str, place: Place, exact: Callable[[ExactClaim], Exact], witness: Callable[[Witness], Testimony]
    ) -> Assertion:
        decide = partial(exact, judge) if judge is not None else partial(Exact, "undecided", reason)
        return Assertion(text, place, decide, witness)

    def images(quantities: Iterable[Quantity]) -> list[Covector]:
        return [special.covector(q.coefficients) for q in quantities]

    if claim.rank is not None:
        exact, seen = (
            partial(ExactClaim.rank, asserted=claim.rank),
            partial(Witness.rank, asserted=claim.rank),
        )
        yield one(f"rank {claim.rank}", claim.rank_place or claim.place, exact, seen)
    if claim.basis is not None:
        rows = claim.basis
        size = f" (rank {judge.analysis.rank})" if judge else ""
        these = "this combination is" if len(rows) == 1 else f"these {len(rows)} combinations are"
        text = f"{these} a complete basis{size}"
        place = rows[0].place if rows else claim.place
        exact, seen = partial(ExactClaim.complete, basis=rows), partial(Witness.basis, covectors=images(rows))
        yield replace(one(text, place, exact, seen), basis=rows)
    for q in claim.observable:
        exact = partial(ExactClaim.observable, quantity=q)
        yield one(
            f"{text_of(q)} is observable", q.place, exact, partial(Witness.observable, covectors=images([q]))
        )
    for q in claim.unobservable:
        exact = partial(ExactClaim.unobservable, quantity=q)
        seen = partial(Witness.unobservable, covector=images([q])[0])
        yield one(f"{text_of(q)} is not observable", q.place, exact, seen)
    if claim.detectable is not None:
        asserted, place = claim.detectable
        text = "detectable" if asserted else "not detectable"
        structure = judge.analysis.structure if judge else None
        seen = partial(Witness.detectable, structure=structure, asserted=asserted)
        exact = partial(ExactClaim.detectable, asserted=asserted)
        yield replace(one(text, place, exact, seen), witness_decides=True)
    for q in claim.directions:
        exact, seen = (
            partial(ExactClaim.direction, quantity=q),
            partial(Witness.direction, direction=images([q])[0]),
        )
        yield one(f"direction ({direction_text(q.coefficients)}) is unobservable", q.place, exact, seen)
    for state, (verdict, place) in claim.states.items():
        exact = partial(ExactClaim.state, name=state, verdict=verdict)
        seen = partial(Witness.state, name=state, verdict=verdict)
        yield one(f"{state} is {verdict}", place, exact, seen)


def _verified(basis: tuple[Quantity, ...], ground: Ground, found: CheckResult) -> Verification | None:
    """Return a claimed basis against the Gramian, each false row with its correction."""
    if isinstance(ground.witness, str):
        return None
    rows = [ground.special.covector(q.coefficients) for q in basis]
    texts = [text_of(q) for q in basis]
    verified = verify_basis(ground.witness, rows, texts)
    of = {change.of: change.corrected for change in reversed(found.corrections)}
    combinations = tuple(replace(one, correction=of.get(one.expression, "")) for one in verified.combinations)
    return replace(verified, combinations=combinations)


def _judged(one: Assertion, suffix: str, witness: Witness | str) -> CheckResult:
    """Put the verdicts of both sides together."""
    try:
        exact = one.exact()
    except UndecidedError as error:
        exact = Exact("undecided", str(error))
    testimony = Testimony("silent", witness) if isinstance(witness, str) else one.witness(witness)
    verdict, reason = exact.verdict, exact.reason
    if testimony.word == "denies" and verdict != "fails":
        start = f"undecided exactly ({reason}); " if verdict == "undecided" else f"{reason}, but "
        verdict, reason = "fails", start + testimony.words
    elif verdict == "undecided" and testimony.word == "agrees" and one.witness_decides:
        verdict, reason = "holds", f"not proved, but computed: {testimony.words}"
    elif verdict == "fails" and testimony.word == "agrees":
        reason += f"; at the file's values, {testimony.words}" if not suffix else ""
    elif testimony.words:
        reason = "; ".join(part for part in (reason, testimony.words) if part)
    return CheckResult(
        claim=one.text + suffix,
        verdict=verdict,
        reason=reason,
        place=one.place,
        gramian=testimony.indicator,
        corrections=exact.corrections,
        counterexample=with_trajectories(exact, witness),
        transformation=exact.transformation,
    )
