"""Terms f(t) dᵀx0 of the outputs made into relations, and what their d say of each state.

A state is in situation 1 exactly if e_i is in the span of all d: a reduced echelon form then has the row
e_i. It is in situation 3 exactly if the i-th entry of every d is zero, else in situation 2. Nothing here
knows of the elimination that proved the rank.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from obscli.exact.echelon import Echelon, polynomial_row
from obscli.exact.errors import UndecidedError
from obscli.exact.relations_finding import Relation
from obscli.exact.rows import dot, field_row


if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from obscli.exact.echelon import PolyRow
    from obscli.exact.exact_system import Row
    from obscli.exact.field import Element, Field
    from obscli.exact.polynomial import Polynomial
    from obscli.exact.relations_finding import Situation
    from obscli.model.expression import Expression
    from obscli.model.system import System


class Writer(Protocol):
    """Writes elements and rows of a field as expressions, as the ``Restorer`` does."""

    def element(self, element: Element) -> Expression:
        """Return an element as it is."""
        ...

    def row(self, row: Mapping[int, Polynomial]) -> dict[int, Expression]:
        """Return a row up to a factor."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Term:
    """f(t) dᵀx0 of one output, d as a row over the field."""

    function: Expression
    output: str
    row: Row


@dataclass(frozen=True, slots=True, eq=False)
class Terms:
    """Relations, and the reduced echelon form of all their d by pivot."""

    relations: tuple[Relation, ...]
    span: Mapping[int, PolyRow]


def related(field: Field, states: Sequence[str], writer: Writer, terms: Iterable[Term]) -> Terms:
    """Return the terms with d ≠ 0 as relations, each marked where its d is independent of those before."""
    echelon = Echelon(field, range(len(states)))
    relations = []
    for term in terms:
        if not term.row:
            continue
        row = polynomial_row(field, term.row)
        rest = echelon.reduce(row)
        if rest:
            echelon.insert(echelon.strip(rest))
        coefficients = {states[j]: writer.element(term.row[j]) for j in sorted(term.row)}
        readable = writer.row(row)
        combination = {states[j]: readable[j] for j in sorted(readable)}
        relations.append(Relation(term.function, term.output, coefficients, combination, bool(rest)))
    return Terms(tuple(relations), echelon.rows)


def situations(states: Sequence[str], span: Mapping[int, PolyRow]) -> dict[str, Situation]:
    """Return the situation of each state, from the reduced echelon form of all d alone."""
    found: dict[str, Situation] = dict.fromkeys(states, 3)
    for row in span.values():
        for j in row:
            found[states[j]] = 1 if len(row) == 1 else 2
    return found


def require_same_space(field: Field, span: Mapping[int, PolyRow], kernel: Iterable[Row], rank: int) -> None:
    """Prove that the d span the rows of the observability matrix: as many, and d N = 0.

    Raises
    ------
    UndecidedError : they do not
    """
    columns = list(kernel)
    rows = [field_row(field, row) for row in span.values()]
    if len(rows) != rank or any(dot(field, row, column) for row in rows for column in columns):
        raise UndecidedError("the relations do not span the rows of the observability matrix")


def names_in(system: System) -> frozenset[str]:
    """Return the names that a new one must differ from."""
    names = {system.time, *system.state_names, *(output.name for output in system.outputs)}
    names |= {parameter.name for parameter in system.parameters}
    return frozenset(names | {function.name for function in system.functions})
