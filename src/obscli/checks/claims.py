"""Claims of a model file (``claims`` and ``expect``) checked exactly against the proved analysis.

A combination c is observable iff c N = 0; a direction d is unobservable iff S d = 0; a basis is complete
iff its rows are observable, independent, and as many as the rank.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from typing import TypeAlias

from obscli.core.check import CheckResult
from obscli.core.place import Place
from obscli.exact.analysis import Options, analyze
from obscli.exact.echelon import PolyRow, polynomial_row, reduced_echelon
from obscli.exact.errors import UndecidedError, UndefinedError
from obscli.exact.exact_system import ExactSystem, Row, read_system
from obscli.exact.field import Element
from obscli.exact.finding import Analysis, Undecided
from obscli.exact.nonzero import first_nonzero, require_independent
from obscli.exact.rows import dot
from obscli.model.expression import Expression
from obscli.model.notation import covector_text, to_text
from obscli.model.specialise import Specialisation, at_nominal
from obscli.model.system import Claim, Covector, Quantity, System


#: What a claim is compared with, and the replacement of parameters under which.
_Ground: TypeAlias = "tuple[Analysis | Undecided, Specialisation]"


def check_claims(system: System, analysis: Analysis) -> tuple[CheckResult, ...]:
    """Check every claim of a system, each part by itself, in the order of the file.

    Parameters
    ----------
    system : the system with its claims
    analysis : its proved analysis at generic values
    """
    grounds: dict[str, _Ground] = {"": (analysis, Specialisation(system, {}))}
    results: list[CheckResult] = []
    for claim in system.claims:
        key = _where(claim.at)
        if key not in grounds:
            grounds[key] = _specialised(system, claim)
        results += _check_claim(claim, *grounds[key])
    return tuple(results)


def _where(at: object) -> str:
    if isinstance(at, Mapping):
        return ", ".join(f"{name} = {to_text(value)}" for name, value in at.items())
    return "the file's values" if at == "nominal" else ""


def _specialised(system: System, claim: Claim) -> _Ground:
    special = at_nominal(system) if claim.at == "nominal" else Specialisation(system, _values(claim))
    return analyze(special.system(), Options(critical=False, certificate=False)), special


def _values(claim: Claim) -> Mapping[str, Expression]:
    return claim.at if isinstance(claim.at, Mapping) else {}


def _check_claim(
    claim: Claim, ground: Analysis | Undecided, special: Specialisation
) -> Iterator[CheckResult]:
    suffix = f" at {where}" if (where := _where(claim.at)) else ""
    if isinstance(ground, Undecided):
        yield CheckResult(f"claim{suffix}", "undecided", ground.reason, claim.place)
        return
    try:
        yield from _Checker(claim, ground, special, suffix).results()
    except (UndecidedError, UndefinedError) as error:
        yield CheckResult(f"claim{suffix}", "undecided", str(error), claim.place)


class _Checker:
    """One claim against one analysis, all in one field."""

    def __init__(self, claim: Claim, analysis: Analysis, special: Specialisation, suffix: str) -> None:
        self.claim, self.analysis, self.suffix = claim, analysis, suffix
        self.image = {id(q): special.covector(q.coefficients) for q in _quantities(claim)}
        covectors = [
            *self.image.values(),
            *analysis.unobservable,
            *(c.coefficients for c in analysis.combinations),
        ]
        self.exact: ExactSystem = read_system(analysis.system, [e for c in covectors for e in c.values()])
        self.kernel = [self.exact.row(direction) for direction in analysis.unobservable]
        self.basis = [self.exact.row(c.coefficients) for c in analysis.combinations]

    def row(self, quantity: Quantity) -> dict[int, Element]:
        """Return a claimed linear form, specialised, as field elements by column."""
        return self.exact.row(self.image[id(quantity)])

    def results(self) -> Iterator[CheckResult]:
        """Yield the verdict on each part of the claim."""
        claim = self.claim
        if claim.rank is not None:
            yield self._rank(claim.rank, claim.rank_place or claim.place)
        if claim.basis is not None:
            place = claim.basis[0].place if claim.basis else claim.place
            text = f"these {len(claim.basis)} combinations are a complete basis (rank {self.analysis.rank})"
            yield self._decide(text, partial(self._basis, claim.basis), place)
        for q in claim.observable:
            yield self._decide(f"{_text(q)} is observable", partial(self._observable, q), q.place)
        for q in claim.unobservable:
            yield self._decide(f"{_text(q)} is not observable", partial(self._unobservable, q), q.place)
        for q in claim.directions:
            yield self._decide(self._written(q), partial(self._direction, q), q.place)
        for state, (verdict, place) in claim.states.items():
            found = self.analysis.states.get(state, "not a state here")
            yield self._verdict(f"{state} is {verdict}", found == verdict, f"it is {found}", place)
        for field, (_, place) in claim.other.items():
            yield CheckResult(f"{field}{self.suffix}", "undecided", f"{field} is not checked yet", place)

    def _verdict(self, text: str, holds: object, reason: str, place: Place) -> CheckResult:
        return CheckResult(
            text + self.suffix, "holds" if holds else "fails", "proved exactly" if holds else reason, place
        )

    def _decide(self, text: str, problem: Callable[[], str], place: Place) -> CheckResult:
        """Return the verdict on a claim by what is wrong with it (empty: nothing), undecided where it is."""
        try:
            reason = problem()
        except UndecidedError as error:
            return CheckResult(text + self.suffix, "undecided", str(error), place)
        return self._verdict(text, not reason, reason, place)

    def _rank(self, rank: int, place: Place) -> CheckResult:
        found = self.analysis.rank
        return self._verdict(f"rank {rank}", found == rank, f"the rank is {found}", place)

    def _unseen(self, quantity: Quantity) -> int | None:
        """Return the first unobservable direction that a combination does not annihilate."""
        row: Row = self.row(quantity)
        products = [dot(self.exact.field, row, column) for column in self.kernel]
        return first_nonzero(self.exact.interpreter, products)

    def _unobservable(self, quantity: Quantity) -> str:
        return "it is an observable combination" if self._unseen(quantity) is None else ""

    def _observable(self, quantity: Quantity) -> str:
        k = self._unseen(quantity)
        if k is None:
            return ""
        direction = ", ".join(f"{s}: {to_text(e)}" for s, e in self.analysis.unobservable[k].items())
        return f"not observable: it changes along the unobservable direction ({direction})"

    def _basis(self, basis: tuple[Quantity, ...]) -> str:
        problems = [f"{_text(q)} is {why}" for q in basis if (why := self._observable(q))]
        return "; ".join(problems or self._incomplete(basis))

    def _incomplete(self, basis: tuple[Quantity, ...]) -> list[str]:
        independent: list[PolyRow] = []
        problems = []
        for q in basis:
            rows = [*independent, self._polynomial_row(q)]
            if len(reduced_echelon(self.exact.field, rows, range(self.exact.n))) < len(rows):
                problems.append(f"{_text(q)} is superfluous: it depends on the rows above it")
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

    def _direction(self, quantity: Quantity) -> str:
        column = self.row(quantity)
        if not column:
            return "it is zero"
        products = [dot(self.exact.field, row, column) for row in self.basis]
        seen = first_nonzero(self.exact.interpreter, products)
        if seen is None:
            return ""
        combination = _covector(self.analysis.combinations[seen].coefficients)
        return f"the observable combination {combination} changes along it"

    def _written(self, quantity: Quantity) -> str:
        written = ", ".join(f"{s}: {to_text(e)}" for s, e in quantity.coefficients.items())
        return f"direction ({written}) is unobservable"


def _quantities(claim: Claim) -> Iterable[Quantity]:
    return [*(claim.basis or ()), *claim.observable, *claim.unobservable, *claim.directions]


def _text(quantity: Quantity) -> str:
    return quantity.text or quantity.name or _covector(quantity.coefficients)


def _covector(covector: Covector) -> str:
    return covector_text(covector, tuple(covector))
