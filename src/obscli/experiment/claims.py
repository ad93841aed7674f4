"""Claims about experiments, checked as those about stages are: exactly, and against the joint Gramian."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from obscli.checks.claims import Ground, check_claim, where_text
from obscli.checks.exact_claim import quantities_of
from obscli.checks.witness import Witness
from obscli.core.check import CheckResult
from obscli.core.place import Place
from obscli.exact.finding import Analysis
from obscli.experiment.own_symbols import told_apart
from obscli.experiment.special import at_file, nominal, specialised
from obscli.experiment.stacked import Memo, Stack, proved
from obscli.experiment.witnessed import Look, witnessed
from obscli.model.specialise import Specialisation, at_nominal
from obscli.model.system import Claim, Run, System
from obscli.numeric.settings import Settings


@dataclass(frozen=True, slots=True, eq=False)
class Subject:
    """What claims are about: the runs, those that may be named, what they share, how Gramians are found."""

    runs: tuple[Run, ...]
    known: tuple[Run, ...]
    shared: tuple[str, ...]
    look: Look
    settings: Settings
    base: System
    memo: Memo


def check_experiment_claims(claims: Sequence[Claim], subject: Subject) -> Iterator[CheckResult]:
    """Yield the verdict on every part of every claim."""
    grounds: dict[tuple[str, ...], Ground] = {}
    known = [run.name for run in subject.known]
    for claim in claims:
        missing = [(name, place) for name, place in claim.runs if name not in known]
        if missing:
            yield from (_no_run(name, place, known) for name, place in missing)
            continue
        which = tuple(name for name, _ in claim.runs)
        key = (where_text(claim.at), *which)
        if key not in grounds:
            grounds[key] = _ground(claim, which, subject)
        of = f" by {', '.join(which)}" if which else ""
        sound, wrong = _about_shared(claim, subject.shared)
        yield from wrong
        for found in check_claim(sound, grounds[key]):
            yield replace(found, claim=f"{found.claim.replace('observable', 'determined')}{of}")


def _no_run(name: str, place: Place, known: Sequence[str]) -> CheckResult:
    return CheckResult(f"{name} is a run", "fails", f"the runs are {', '.join(known)}", place)


def _about_shared(claim: Claim, shared: Sequence[str]) -> tuple[Claim, list[CheckResult]]:
    """Return the claim with `all` written out, without parts about states that are not shared: those fail."""
    kept = frozenset(shared)
    wrong = [
        CheckResult(
            f"{one.text or one.name} is a combination of shared states",
            "fails",
            f"{', '.join(sorted(one.coefficients.keys() - kept))} starts anew in every run",
            one.place,
        )
        for one in quantities_of(claim)
        if not kept.issuperset(one.coefficients)
    ]
    wrong += [
        CheckResult(f"{name} is shared", "fails", f"{name} starts anew in every run", place)
        for name, (_, place) in claim.states.items()
        if name not in kept
    ]
    everyone = {} if claim.everything is None else dict.fromkeys(shared, ("observable", claim.everything))
    inside = {name: verdict for name, verdict in claim.states.items() if name in kept}
    fine = [one for one in quantities_of(claim) if kept.issuperset(one.coefficients)]
    sound = replace(
        claim,
        basis=None if claim.basis is None or not set(claim.basis) <= set(fine) else claim.basis,
        observable=tuple(one for one in claim.observable if one in fine),
        unobservable=tuple(one for one in claim.unobservable if one in fine),
        directions=tuple(one for one in claim.directions if one in fine),
        states={**everyone, **inside},
    )
    return sound, wrong


def _ground(claim: Claim, which: Sequence[str], subject: Subject) -> Ground:
    named = [run for run in subject.known if run.name in which]
    chosen = named or subject.runs
    runs, own = told_apart(chosen, subject.base)
    generic = proved(runs, subject.shared, memo=subject.memo)
    if claim.at is None:
        special = Specialisation(generic.system, {})
        return Ground(generic.finding, special, _witness(generic, subject))
    if claim.at == "nominal":
        there = nominal(generic, subject.shared, subject.memo)
        return Ground(there.finding, at_nominal(generic.system), _witness(there, subject))
    values = {**claim.at, **{one.name: claim.at[one.of] for one in own if one.of in claim.at}}
    there = specialised(generic, subject.shared, values)
    return Ground(there.finding, Specialisation(generic.system, values), _witness(there, subject))


def _witness(stack: Stack, subject: Subject) -> Witness | str:
    """Return the joint Gramian, or why it is no witness."""
    if not isinstance(stack.finding, Analysis):
        return "the exact side is undecided"
    rank = at_file(stack, subject.shared, None, subject.memo).rank
    if rank is not None and rank != stack.finding.rank:
        return f"the Gramians are no witness: at the file's values the rank is {rank}"
    runs = [one.run for one in stack.runs]
    seen = witnessed(runs, stack.system, subject.look, subject.settings)
    return (
        f"no Gramian: {seen.reason}" if seen.together is None else Witness(seen.together, stack.finding.rank)
    )
