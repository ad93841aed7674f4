"""One claim against one proved analysis, exactly, with what is wrong where it is false.

A combination c is observable iff c N = 0; a direction d is unobservable iff S d = 0; a basis is complete
iff its rows are observable, independent, and as many as the rank.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Final

from obscli.checks.detectability import exact_detectability
from obscli.core.check import Change, Counterexample, Verdict
from obscli.core.number import counted
from obscli.exact.correction import Correction, corrections
from obscli.exact.echelon import PolyRow, polynomial_row, reduced_echelon
from obscli.exact.equivalence import is_rearranged, transformation
from obscli.exact.exact_system import ExactSystem, Row, read_system
from obscli.exact.field import Element
from obscli.exact.finding import Analysis
from obscli.exact.nonzero import first_nonzero, require_independent
from obscli.exact.restore import Restorer
from obscli.exact.rows import dot, is_solution
from obscli.exact.sample_window import static
from obscli.model.notation import covector_text, to_text
from obscli.model.specialise import Specialisation
from obscli.model.system import Claim, Covector, Quantity


@dataclass(frozen=True, slots=True, eq=False)
class Exact:
    """What exact algebra says of one assertion, why, and what would be right."""

    verdict: Verdict
    reason: str = ""
    corrections: tuple[Change, ...] = ()
    counterexample: Counterexample | None = None
    direction: Covector | None = None
    claimed: Covector | None = None
    transformation: tuple[tuple[str, ...], ...] = ()


PROVED: Final = Exact("holds", "proved exactly")


class ExactClaim:
    """One claim and its ground, all in one field.

    Parameters
    ----------
    claim : as in the file
    analysis : the analysis at the values of the claim
    special : the replacement of parameters at these values

    Raises
    ------
    UndecidedError, UndefinedError
        where a coefficient of the claim cannot be read at these values
    """

    def __init__(self, claim: Claim, analysis: Analysis, special: Specialisation) -> None:
        self.analysis = analysis
        self.image = {id(q): special.covector(q.coefficients) for q in quantities_of(claim)}
        covectors = [
            *self.image.values(),
            *analysis.unobservable,
            *(c.coefficients for c in analysis.combinations),
        ]
        self.exact: ExactSystem = read_system(
            static(analysis.system), [e for c in covectors for e in c.values()]
        )
        self.kernel = [self.exact.row(direction) for direction in analysis.unobservable]
        self.basis = [self.exact.row(c.coefficients) for c in analysis.combinations]

    def row(self, quantity: Quantity) -> dict[int, Element]:
        """Return a claimed linear form, specialised, as field elements by column."""
        return self.exact.row(self.image[id(quantity)])

    def rank(self, asserted: int) -> Exact:
        """Say whether the rank is the one asserted."""
        found = self.analysis.rank
        return PROVED if found == asserted else Exact("fails", f"the rank is {found}")

    def state(self, name: str, verdict: str) -> Exact:
        """Say whether a state is observable, coupled or unobservable as asserted."""
        found = self.analysis.states.get(name, "not a state here")
        return PROVED if found == verdict else Exact("fails", f"it is {found}")

    def detectable(self, *, asserted: bool) -> Exact:
        """Say whether what is unobservable dies out, or does not, as asserted."""
        if self.analysis.structure is None:
            return Exact("undecided", "the structure was not asked for")
        found = exact_detectability(self.analysis.structure)
        if found.verdict == "undecided":
            return Exact("undecided", found.words)
        same = asserted == (found.verdict != "not detectable")
        return Exact("holds" if same else "fails", f"{'proved exactly: ' if same else ''}{found.words}")

    def unobservable(self, quantity: Quantity) -> Exact:
        """Say whether a combination is not observable."""
        if self._unseen(quantity) is None:
            return Exact("fails", "it is an observable combination")
        return PROVED

    def observable(self, quantity: Quantity) -> Exact:
        """Say whether a combination is observable; if not, along which direction it changes, and what is."""
        k = self._unseen(quantity)
        if k is None:
            return PROVED
        direction = self.analysis.unobservable[k]
        changes = tuple(
            self._change(quantity, one) for one in corrections(self.exact, self.kernel, self.row(quantity))
        )
        reason = f"not observable: it changes along the unobservable direction ({direction_text(direction)})"
        return Exact(
            "fails", reason, changes, self._counterexample(quantity, k), direction, self.image[id(quantity)]
        )

    def complete(self, basis: tuple[Quantity, ...]) -> Exact:
        """Say whether combinations are a basis of all observable ones."""
        wrong = [(q, found) for q in basis if (found := self.observable(q)).verdict == "fails"]
        if wrong:
            reasons = "; ".join(f"{text_of(q)} is {found.reason}" for q, found in wrong)
            if len(basis) != self.analysis.rank:
                reasons += f"; and {counted(len(basis), 'row')}, where the rank is {self.analysis.rank}"
            changes = tuple(change for _, found in wrong for change in found.corrections)
            return replace(wrong[0][1], reason=reasons, corrections=changes)
        problems = self._incomplete(basis)
        if problems:
            return Exact("fails", "; ".join(problems))
        matrix = transformation(self.exact, self.basis, [self.row(q) for q in basis])
        if matrix is None or is_rearranged(matrix):
            return PROVED
        written = tuple(
            tuple(to_text(row[k]) if k in row else "0" for k in range(len(self.basis))) for row in matrix
        )
        return Exact(
            "holds", "proved exactly (equivalent: another basis of the same space)", transformation=written
        )

    def direction(self, quantity: Quantity) -> Exact:
        """Say whether a vector of the state is unobservable."""
        column = self.row(quantity)
        if not column:
            return Exact("fails", "it is zero")
        products = [dot(self.exact.field, row, column) for row in self.basis]
        seen = first_nonzero(self.exact.interpreter, products)
        if seen is None:
            return PROVED
        combination = _covector(self.analysis.combinations[seen].coefficients)
        return Exact("fails", f"the observable combination {combination} changes along it")

    def _unseen(self, quantity: Quantity) -> int | None:
        """Return the first unobservable direction that a combination does not annihilate."""
        row: Row = self.row(quantity)
        products = [dot(self.exact.field, row, column) for column in self.kernel]
        return first_nonzero(self.exact.interpreter, products)

    def _counterexample(self, quantity: Quantity, k: int) -> Counterexample:
        direction, column = self.analysis.unobservable[k], self.kernel[k]
        product = dot(self.exact.field, self.row(quantity), column)
        return Counterexample(
            direction={state: to_text(entry) for state, entry in direction.items()},
            claim=to_text(Restorer(self.exact.interpreter).element(product)),
            is_trajectory=self.exact.system is self.analysis.system and is_solution(self.exact, column),
        )

    def _change(self, quantity: Quantity, one: Correction) -> Change:
        states = self.exact.system.state_names
        corrected = covector_text(one.corrected, states)
        before = self.image[id(quantity)]
        words = " and ".join(_changed(state, before, one.corrected) for state in one.change)
        return Change(text_of(quantity), covector_text(one.change, states), corrected, words)

    def _incomplete(self, basis: tuple[Quantity, ...]) -> list[str]:
        independent: list[PolyRow] = []
        problems = []
        for q in basis:
            rows = [*independent, self._polynomial_row(q)]
            if len(reduced_echelon(self.exact.field, rows, range(self.exact.n))) < len(rows):
                problems.append(f"{text_of(q)} is superfluous: it depends on the rows above it")
            else:
                independent = rows
        missing = self.analysis.rank - len(independent)
        if not problems and not missing:
            require_independent(self.exact.interpreter, [self.row(q) for q in basis])
        if missing:
            forgotten = self._forgotten(independent)
            problems.append(f"{missing} forgotten, for example {forgotten}")
        return problems

    def _polynomial_row(self, quantity: Quantity) -> PolyRow:
        return polynomial_row(self.exact.field, self.row(quantity))

    def _forgotten(self, independent: list[PolyRow]) -> str:
        """Return a combination of the proved basis that the claimed rows do not span."""
        for combination, row in zip(self.analysis.combinations, self.basis, strict=True):
            rows = [*independent, polynomial_row(self.exact.field, row)]
            if len(reduced_echelon(self.exact.field, rows, range(self.exact.n))) == len(rows):
                return _covector(combination.coefficients)
        return "a combination of the proved basis"


def _changed(state: str, before: Covector, after: Covector) -> str:
    """Say what a change does to one state of a combination."""
    if state not in before:
        term = covector_text({state: after[state]}, (state,))
        return f"lacks - {term[1:]}" if term.startswith("-") else f"lacks + {term}"
    if state not in after:
        return f"has a term in {state} too much"
    return f"has {to_text(before[state])} where {state} needs {to_text(after[state])}"


def quantities_of(claim: Claim) -> Iterable[Quantity]:
    """Return every linear form and direction of a claim."""
    return [*(claim.basis or ()), *claim.observable, *claim.unobservable, *claim.directions]


def text_of(quantity: Quantity) -> str:
    """Return a claimed combination as it was written."""
    return quantity.text or quantity.name or _covector(quantity.coefficients)


def direction_text(direction: Covector) -> str:
    """Return a direction as ``claims`` write it: state: component, …."""
    return ", ".join(f"{state}: {to_text(entry)}" for state, entry in direction.items())


def _covector(covector: Covector) -> str:
    return covector_text(covector, tuple(covector))
