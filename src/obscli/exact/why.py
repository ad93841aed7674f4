"""Why a combination of the states can be estimated, or not: what sees it, what hides it, what would help.

c is observable iff c N = 0. The unobservable directions d with c d ≠ 0 are those through it: along them it
changes and no output shows that. A change of the system helps where c N = 0 afterwards.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Literal

from obscli.exact.analysis import analyze
from obscli.exact.correction import corrections
from obscli.exact.echelon import polynomial_row
from obscli.exact.errors import JetOverflowError, UndecidedError, UndefinedError
from obscli.exact.exact_system import more_jets, read_system
from obscli.exact.finding import Analysis, Combination, Undecided
from obscli.exact.origin import first_rows
from obscli.exact.prove import Proof, prove
from obscli.exact.restore import Restorer
from obscli.exact.rows import dot, field_row
from obscli.exact.saturation import saturate
from obscli.exact.structure_finding import Mode
from obscli.exact.verdicts import groups, quantity_verdict
from obscli.model.expression import ONE
from obscli.model.measured import with_output
from obscli.model.notation import covector_text
from obscli.model.specialise import at_nominal
from obscli.model.system import Covector, Quantity, System


if TYPE_CHECKING:
    from obscli.exact.exact_system import ExactSystem
    from obscli.exact.finding import LinearFormVerdict

#: Of states that would show it if they were measured, so many are proved and named.
_MOST_PROVED: Final = 8

#: Smallest changes that make it observable, so many are named.
_MOST_CORRECTIONS: Final = 3


@dataclass(frozen=True, slots=True, eq=False)
class Remedy:
    """A change of the system, what the target becomes, and the rank then.

    ``proved``: exactly; otherwise tried modulo a prime.
    """

    change: str
    kind: Literal["output", "fix", "stage", "values"]
    becomes: LinearFormVerdict
    rank: int
    proved: bool


@dataclass(frozen=True, slots=True, eq=False)
class Explanation:
    """Why a linear form in the states is observable, or is not.

    Parameters
    ----------
    target : its name and coefficients
    verdict : of it, at generic values
    group : the states that it is coupled with
    directions : the unobservable directions along which it changes
    modes : how these directions move, where that is known exactly
    seen_by : the output, and the order of its derivative, that first yields it; None where nothing does
    combinations : those of the basis in which its states occur, where it is not observable by itself
    corrections : the smallest changes of it that are observable
    remedies : changes of the system after which it is observable
    at_values : what it is at the file's values, where the rank is another there
    """

    system: System
    target: Quantity
    verdict: LinearFormVerdict
    rank: int
    group: tuple[str, ...]
    directions: tuple[Covector, ...]
    modes: tuple[Mode, ...]
    seen_by: tuple[str, int] | None
    combinations: tuple[Combination, ...]
    corrections: tuple[Covector, ...]
    remedies: tuple[Remedy, ...] = ()
    at_values: Remedy | None = None


def explain(system: System, target: Quantity) -> Explanation | Undecided:
    """Explain the verdict on a linear form in the states of a system, and which measured state would help."""
    finding = analyze(system)
    if isinstance(finding, Undecided):
        return finding
    try:
        return _explained(finding, target)
    except (UndecidedError, UndefinedError) as error:
        return Undecided(system, str(error))


def _explained(finding: Analysis, target: Quantity) -> Explanation:
    system = finding.system
    proof = prove(system, range(system.n), target.coefficients.values())
    exact, columns = proof.exact, proof.kernel.columns
    found = quantity_verdict(target, exact, columns, groups(proof.flag.rows))
    row = exact.row(target.coefficients)
    through = [f for f, column in columns.items() if dot(exact.field, row, field_row(exact.field, column))]
    names = set(target.coefficients)
    hidden = found.verdict != "observable"
    return Explanation(
        system=system,
        target=target,
        verdict=found.verdict,
        rank=proof.rank,
        group=tuple(name for name in found.group if name not in names) if hidden else (),
        directions=tuple(proof.directions[f] for f in through),
        modes=tuple(_modes_through(finding, exact, target)),
        seen_by=None if hidden else _seen_by(proof, target),
        combinations=tuple(c for c in finding.combinations if hidden and names & c.coefficients.keys()),
        corrections=tuple(_corrections(proof, target)) if found.verdict == "coupled" else (),
        remedies=tuple(_measured(proof, target)) if hidden else (),
        at_values=_at_values(finding, target),
    )


def _at_values(finding: Analysis, target: Quantity) -> Remedy | None:
    """Return the verdict at the file's values where the rank there is not the generic one."""
    if finding.at_values.rank in {None, finding.rank}:
        return None
    verdict, rank = verdict_in(*at_values(finding.system, target))
    return Remedy(", ".join(finding.at_values.because), "values", verdict, rank, proved=True)


def at_values(system: System, target: Quantity) -> tuple[System, Quantity]:
    """Return a system and a linear form in its states at the file's values."""
    special = at_nominal(system)
    return special.system(), replace(target, coefficients=special.covector(target.coefficients))


def _modes_through(finding: Analysis, exact: ExactSystem, target: Quantity) -> Iterator[Mode]:
    """Yield the modes of the unobservable subspace along which the target changes."""
    modes = finding.structure.modes if finding.structure else ()
    if not modes:
        return
    entries = [e for mode in modes for e in mode.direction.values()]
    exact = read_system(exact.system, [*entries, *target.coefficients.values()])
    row = exact.row(target.coefficients)
    for mode in modes:
        if dot(exact.field, row, exact.row(mode.direction)):
            yield mode


def _seen_by(proof: Proof, target: Quantity) -> tuple[str, int]:
    exact = proof.exact
    row = polynomial_row(exact.field, exact.row(target.coefficients))
    [(order, output)] = first_rows(exact, proof.saturation, [row])
    return exact.system.outputs[output].name, order


def _corrections(proof: Proof, target: Quantity) -> Iterator[Covector]:
    exact = proof.exact
    kernel = [field_row(exact.field, column) for column in proof.kernel.columns.values()]
    found = corrections(exact, kernel, exact.row(target.coefficients))
    printed = [_without_denominators(exact.system, one.corrected) for one in found]
    once = {covector_text(one, exact.system.state_names): one for one in printed}
    yield from list(once.values())[:_MOST_CORRECTIONS]


def _without_denominators(system: System, covector: Covector) -> Covector:
    exact = read_system(system, covector.values())
    row = Restorer(exact.interpreter).row(polynomial_row(exact.field, exact.row(covector)))
    return {system.state_names[j]: row[j] for j in sorted(row)}


def _measured(proof: Proof, target: Quantity) -> Iterator[Remedy]:
    """Yield the states that, measured as well, make the target observable.

    Only states in which some unobservable direction has a component can help.
    """
    names = proof.exact.system.state_names
    touched = sorted({j for column in proof.kernel.columns.values() for j in column})
    left = _MOST_PROVED
    for name in (names[j] for j in touched):
        system = with_output(proof.exact.system, {name: ONE})
        if not _shows_modulo_a_prime(system, target):
            continue
        verdict, rank = verdict_in(system, target) if left > 0 else ("observable", proof.rank + 1)
        if verdict == "observable":
            yield Remedy(name, "output", verdict, rank, proved=left > 0)
        left -= 1


def _shows_modulo_a_prime(system: System, target: Quantity) -> bool:
    """Whether the target adds nothing to the rank, at a random point modulo a prime."""
    alone = _rank_modulo_a_prime(system)
    return _rank_modulo_a_prime(with_output(system, target.coefficients)) == alone


def _rank_modulo_a_prime(system: System) -> int:
    exact = read_system(system)
    while True:
        try:
            return saturate(exact).rank
        except JetOverflowError:
            exact = more_jets(exact)


def verdict_in(system: System, target: Quantity) -> tuple[LinearFormVerdict, int]:
    """Return the proved verdict on a linear form in a system, and its rank.

    Raises
    ------
    UndecidedError, UndefinedError : where the rank cannot be proved
    """
    proof = prove(system, range(system.n), target.coefficients.values())
    found = quantity_verdict(target, proof.exact, proof.kernel.columns, groups(proof.flag.rows))
    return found.verdict, proof.rank
