"""Why a combination of the states can be estimated, or not: what sees it, what hides it, what would help.

c is observable iff c N = 0. The unobservable directions d with c d ≠ 0 are those through it: along them it
changes and no output shows that. A change of the system helps where c N = 0 afterwards (``trials``).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from obscli.exact.analysis import Options, analyze
from obscli.exact.correction import corrections
from obscli.exact.echelon import polynomial_row
from obscli.exact.errors import JetOverflowError, UndecidedError, UndefinedError
from obscli.exact.exact_system import read_system
from obscli.exact.finding import Analysis, Combination, Undecided
from obscli.exact.origin import first_rows
from obscli.exact.prove import Proof, prove
from obscli.exact.restore import Restorer
from obscli.exact.rows import dot, field_row
from obscli.exact.structure_finding import Mode
from obscli.exact.trials import Trial, try_measured
from obscli.exact.verdicts import groups, quantity_verdict
from obscli.model.notation import covector_text
from obscli.model.specialise import at_nominal
from obscli.model.system import Covector, Quantity, System


if TYPE_CHECKING:
    from obscli.exact.finding import LinearFormVerdict

#: Of an analysis, no more than this is needed.
LIGHT: Final = Options(critical=False, certificate=False)

#: Smallest changes that make it observable, so many are named.
_MOST_CORRECTIONS: Final = 3


@dataclass(frozen=True, slots=True, eq=False)
class Explanation:
    """Why a linear form in the states is observable, or is not.

    Parameters
    ----------
    target : its name and coefficients
    verdict : of it, at generic values
    rank : of the system
    group : the states that it is coupled with
    directions : the unobservable directions along which it changes
    modes : how these directions move, as far as that is known for all times
    moving : whether some unobservable directions move in a way that depends on time
    seen_by : the output, and the order of its derivative, that first yields it; None where nothing does
    combinations : those of the basis in which its states occur, where it is not observable by itself
    corrections : the smallest changes of it that are observable
    trials : changes of the system after which it is observable, and those of which that was not decided
    at_values : the same at the file's values, where the rank is another there, or why that is not known
    because : of an explanation at the file's values, the conditions that lower the rank
    """

    system: System
    target: Quantity
    verdict: LinearFormVerdict
    rank: int
    group: tuple[str, ...]
    directions: tuple[Covector, ...]
    modes: tuple[Mode, ...]
    moving: bool
    seen_by: tuple[str, int] | None
    combinations: tuple[Combination, ...]
    corrections: tuple[Covector, ...]
    trials: tuple[Trial, ...] = ()
    at_values: Explanation | Undecided | None = None
    because: tuple[str, ...] = ()

    @property
    def remedies(self) -> tuple[Trial, ...]:
        """The changes after which it is observable."""
        return tuple(one for one in self.trials if one.becomes == "observable")

    @property
    def open(self) -> tuple[Trial, ...]:
        """The changes of which it could not be decided."""
        return tuple(one for one in self.trials if one.becomes == "undecided")


def explain(finding: Analysis | Undecided, target: Quantity) -> Explanation | Undecided:
    """Explain the verdict on a linear form in the states of an analysed system.

    Parameters
    ----------
    finding : the analysis of the system; ``LIGHT`` is enough
    target : the linear form

    Returns
    -------
    Explanation or Undecided
        with every state that would make it observable if it were measured
    """
    generic = _explained(finding, target)
    if isinstance(finding, Undecided) or isinstance(generic, Undecided):
        return generic
    return replace(generic, at_values=_at_values(finding, target))


def _at_values(finding: Analysis, target: Quantity) -> Explanation | Undecided | None:
    """Explain the linear form at the file's values where the rank there is not the generic one."""
    at_values = finding.at_values
    if at_values.rank == finding.rank:
        return None
    if at_values.rank is None:
        return Undecided(finding.system, at_values.reason)
    special = at_nominal(finding.system)
    there = replace(target, coefficients=special.covector(target.coefficients))
    found = _explained(analyze(special.system(), LIGHT), there)
    return replace(found, because=at_values.because) if isinstance(found, Explanation) else found


def _explained(finding: Analysis | Undecided, target: Quantity) -> Explanation | Undecided:
    if isinstance(finding, Undecided):
        return finding
    jets = 4
    while True:
        try:
            return _of_proof(finding, target, jets)
        except JetOverflowError:
            jets *= 2
        except (UndecidedError, UndefinedError) as error:
            return Undecided(finding.system, str(error))


def _of_proof(finding: Analysis, target: Quantity, jets: int) -> Explanation:
    system, structure = finding.system, finding.structure
    proof = prove(system, range(system.n), target.coefficients.values(), jets)
    exact, columns = proof.exact, proof.kernel.columns
    found = quantity_verdict(target, exact, columns, groups(proof.flag.rows))
    row = exact.row(target.coefficients)
    through = [f for f, column in columns.items() if dot(exact.field, row, field_row(exact.field, column))]
    names = set(target.coefficients)
    hidden = found.verdict != "observable"
    known = len(structure.modes) == structure.dimension if structure else not columns
    return Explanation(
        system=system,
        target=target,
        verdict=found.verdict,
        rank=proof.rank,
        group=tuple(name for name in found.group if name not in names) if hidden else (),
        directions=tuple(proof.directions[f] for f in through),
        modes=tuple(_modes_through(finding, target, jets)) if through else (),
        moving=bool(through) and not known,
        seen_by=None if hidden else _seen_by(proof, target),
        combinations=tuple(c for c in finding.combinations if hidden and names & c.coefficients.keys()),
        corrections=_corrections(proof, target, jets) if found.verdict == "coupled" else (),
        trials=tuple(try_measured(proof, target)) if hidden else (),
    )


def _modes_through(finding: Analysis, target: Quantity, jets: int) -> Iterator[Mode]:
    """Yield the modes of the unobservable subspace along which the target changes."""
    modes = finding.structure.modes if finding.structure else ()
    entries = [e for mode in modes for e in mode.direction.values()]
    exact = read_system(finding.system, [*entries, *target.coefficients.values()], jets)
    row = exact.row(target.coefficients)
    for mode in modes:
        if dot(exact.field, row, exact.row(mode.direction)):
            yield mode


def _seen_by(proof: Proof, target: Quantity) -> tuple[str, int]:
    exact = proof.exact
    row = polynomial_row(exact.field, exact.row(target.coefficients))
    [(order, output)] = first_rows(exact, proof.saturation, [row])
    return exact.system.outputs[output].name, order


def _corrections(proof: Proof, target: Quantity, jets: int) -> tuple[Covector, ...]:
    exact = proof.exact
    kernel = [field_row(exact.field, column) for column in proof.kernel.columns.values()]
    found = corrections(exact, kernel, exact.row(target.coefficients))
    again = read_system(exact.system, [e for one in found for e in one.corrected.values()], jets)
    restorer, names = Restorer(again.interpreter), again.system.state_names
    readable: dict[str, Covector] = {}
    for one in found:
        # its denominators cleared, so that changes that differ by a factor are the same
        row = restorer.row(polynomial_row(again.field, again.row(one.corrected)))
        covector = {names[j]: row[j] for j in sorted(row)}
        readable.setdefault(covector_text(covector, names), covector)
    return tuple(readable.values())[:_MOST_CORRECTIONS]
