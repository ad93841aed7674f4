"""One stage transformed: to its observable combinations, to the Kalman decomposition, or with states dropped.

Whatever is made is written as a model file first; what is checked and shown is that file, read back.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Final

from obscli.core.place import ModelError
from obscli.exact.basis import sparse_basis
from obscli.exact.dropped import Dropped, drop_unobservable
from obscli.exact.errors import UndecidedError, UndefinedError
from obscli.exact.finding import Undecided
from obscli.exact.kalman import decompose
from obscli.exact.lift_finding import NotReducible
from obscli.exact.lifted_system import lifted_system
from obscli.exact.prove import Proof, prove
from obscli.exact.reduced import in_variables
from obscli.exact.stationary import stationary_of
from obscli.exact.transformed import transformed_system
from obscli.model.reader import read_text
from obscli.model.system import Covector, Model, System
from obscli.model.used import without_unused
from obscli.model.variables import with_plain_lead
from obscli.model.write import write_model
from obscli.pipelines.periodic import periodic_form
from obscli.pipelines.reading import expanded_states
from obscli.pipelines.request import Changes, Target, TransformRequest
from obscli.pipelines.transform_checks import agreement_check, identity_checks, rank_check, zeros_check
from obscli.pipelines.transform_heading import (
    assumption,
    changed,
    drop_words,
    heading,
    kalman_words,
    meanings,
    observable_words,
    stationary_words,
    way_back,
)
from obscli.pipelines.transform_result import (
    Finding,
    NoStationaryForm,
    NothingLeft,
    StationaryForm,
    Transformed,
    TransformResult,
)


#: Why no model is left.
NOTHING: Final = "no combination of the states is observable"


class Transformation:
    """One stage of a model, as it was asked to be transformed."""

    def __init__(self, model: Model, system: System, request: TransformRequest, changes: Changes) -> None:
        self.model, self.system, self.request, self.changes = model, system, request, changes
        first = expanded_states(system, request.pivot_order)
        place = {name: k for k, name in enumerate(first)}
        self.columns = sorted(range(system.n), key=lambda j: place.get(system.state_names[j], len(place)))

    def result(self) -> TransformResult:
        """Return the model made, or why there is none."""
        ways: dict[Target, Callable[[], Finding]] = {
            "observable": self._observable,
            "kalman": self._kalman,
            "stationary": self._stationary,
            "drop": self._dropped,
        }
        finding: Finding
        try:
            finding = ways[self.request.to]()
        except (UndecidedError, UndefinedError) as error:
            finding = Undecided(self.system, str(error))
        return TransformResult(self.model, self.system, self.request.to, finding)

    def _observable(self) -> Transformed | NothingLeft:
        proof = prove(self.system, self.columns)
        if not proof.rank:
            return NothingLeft(NOTHING)
        forms = [with_plain_lead(form) for form in self._basis(proof)]
        coordinates = in_variables(self.system, forms, self.columns)
        made, notes = transformed_system(coordinates)
        left_out = tuple(self.system.state_names[f] for f in sorted(proof.kernel.columns))
        comments = [*way_back(made.state_names, coordinates.back, left_out), *notes]
        text, made = self._written(made, observable_words(self.system, made.n), comments, proof.rank)
        return Transformed(
            system=made,
            text=text,
            forms=coordinates.forms,
            sizes=(proof.rank, self.system.n - proof.rank),
            checks=(*identity_checks(self.system, coordinates.forms, made), rank_check(made, proof.rank)),
            left_out=left_out,
            back=coordinates.back,
            divides_by=coordinates.divides_by,
            notes=notes,
        )

    def _basis(self, proof: Proof) -> tuple[Covector, ...]:
        rows = proof.flag.rows
        if self.request.basis == "sparse":
            found = sparse_basis(proof.exact, rows)
            return tuple(proof.covector(row) for row in sorted(found, key=sorted))
        return tuple(proof.covector(rows[p]) for p in self.columns if p in rows)

    def _kalman(self) -> Transformed:
        found = decompose(self.system, self.columns)
        forms = [with_plain_lead(form) for form in found.variables]
        coordinates = in_variables(self.system, forms, self.columns)
        made, notes = transformed_system(coordinates)
        comments = [*way_back(made.state_names, coordinates.back, ()), *notes]
        text, made = self._written(made, kalman_words(found.sizes, found.by), comments, found.proof.rank)
        checks = (zeros_check(found, made), *identity_checks(self.system, forms, made))
        return Transformed(
            system=made,
            text=text,
            forms=coordinates.forms,
            sizes=found.sizes,
            checks=(*checks, rank_check(made, found.proof.rank)),
            by=found.by,
            back=coordinates.back,
            divides_by=coordinates.divides_by,
            notes=notes,
        )

    def _stationary(self) -> StationaryForm | NoStationaryForm:
        found = stationary_of(prove(self.system, self.columns))
        if isinstance(found, NotReducible):
            return NoStationaryForm(found, periodic_form(self.system))
        made, notes = lifted_system(self.system, found.smallest)
        comments = [*meanings(self.system, found.smallest.names, found.smallest.variables), *notes]
        text, made = self._written(made, stationary_words(self.system, made.n), comments, found.rank)
        checks = (
            *identity_checks(self.system, found.smallest.variables, made, driven=False),
            rank_check(made, found.rank),
            agreement_check(found),
        )
        return StationaryForm(found, made, text, checks, notes)

    def _dropped(self) -> Transformed | NothingLeft:
        system = self.system
        found = drop_unobservable(system, self.columns, in_order=bool(self.request.pivot_order))
        if not found.forms:
            return NothingLeft(NOTHING)
        made, exact = without_unused(found.system), found.is_exact
        notes = tuple(_dropped_too(found))
        comments = [
            *assumption(found.states, found.moved, is_exact=exact),
            *meanings(system, made.state_names, found.forms),
            *notes,
        ]
        text, made = self._written(made, drop_words(found.states, is_exact=exact), comments, made.n)
        checks = identity_checks(system, found.forms, made, driven=False) if exact else ()
        return Transformed(
            system=made,
            text=text,
            forms=found.forms,
            sizes=(made.n, len(found.states)),
            checks=(*checks, rank_check(made, made.n)),
            left_out=found.states,
            notes=notes,
            is_exact=exact,
            moved=found.moved,
        )

    def _written(
        self, made: System, description: str, comments: Sequence[str], rank: int
    ) -> tuple[str, System]:
        """Return the file of a model, and the model as the file reads."""
        above = heading(
            self.model, self.system, self.request.to, description, (*changed(self.changes), *comments), rank
        )
        text = write_model(made, above)
        try:
            return text, read_text(text, f"{above.name}.yaml").systems[0]
        except ModelError as error:
            reason = f"the model is too large to be written: {error.problems[0].message}"
            raise UndecidedError(reason) from error


def _dropped_too(found: Dropped) -> Iterator[str]:
    """Say which inputs are dropped with the states, and which quantities are taken with these zero."""
    if found.lost:
        yield f"dropped with the states that they enter: {', '.join(found.lost)}"
    if found.taken:
        yield f"not observable, taken with the dropped states zero: {', '.join(found.taken)} (quantities)"
