"""Terms f(t) dᵀx0 of the outputs made into relations, and what their d say of each state.

    d N = 0 for all d, exactly;   as many d as the rank are independent at a random point modulo a prime

The first bounds the rank of the d from above, the second from below: they span the rows of the observability
matrix. A state is in situation 1 where a reduced form of the d has the row e_i, in 3 where the i-th entry of
every d is zero, else in 2. The reduced form is taken at that point too, from the d alone; that e_i is in
their span exactly if e_i N = 0 confirms it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Protocol

from flint import nmod_mat

from obscli.exact.echelon import polynomial_row
from obscli.exact.errors import UndecidedError
from obscli.exact.relations_finding import Relation
from obscli.exact.rows import dot
from obscli.exact.series import PRIME, BadPointError, SeriesPoint


if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from obscli.exact.exact_system import Row
    from obscli.exact.field import Element, Field
    from obscli.exact.polynomial import Polynomial
    from obscli.exact.relations_finding import Situation
    from obscli.model.expression import Expression
    from obscli.model.system import System


NOT_THE_SPAN: Final = "the relations do not span the rows of the observability matrix"
_SEED: Final = 20260519
_ATTEMPTS: Final = 20


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
    """Relations, and the situation of each state by their d."""

    relations: tuple[Relation, ...]
    situations: dict[str, Situation]


def related(
    field: Field,
    states: Sequence[str],
    writer: Writer,
    terms: Iterable[Term],
    kernel: Sequence[Row],
    rank: int,
) -> Terms:
    """Return the terms with d ≠ 0 as relations, each marked where its d is independent of those before.

    Parameters
    ----------
    field : of the d and of the kernel
    states : their names
    writer : writes elements of the field
    terms : the terms of all outputs
    kernel : the columns of N
    rank : of the observability matrix

    Raises
    ------
    UndecidedError : the d do not span the rows of the observability matrix
    """
    terms = [term for term in terms if term.row]
    if any(dot(field, term.row, column) for term in terms for column in kernel):
        raise UndecidedError(NOT_THE_SPAN)
    values = modulo(field, [term.row for term in terms], len(states))
    first = _pivots(values.transpose())
    if len(first) != rank:
        raise UndecidedError(NOT_THE_SPAN)
    relations = [_relation(states, field, writer, term, k in first) for k, term in enumerate(terms)]
    return Terms(tuple(relations), _situations(states, values, terms, kernel))


def _relation(
    states: Sequence[str],
    field: Field,
    writer: Writer,
    term: Term,
    independent: bool,  # noqa: FBT001
) -> Relation:
    readable = writer.row(polynomial_row(field, term.row))
    return Relation(
        term.function,
        term.output,
        {states[j]: writer.element(term.row[j]) for j in sorted(term.row)},
        {states[j]: readable[j] for j in sorted(readable)},
        independent,
    )


def _situations(
    states: Sequence[str], values: nmod_mat, terms: Sequence[Term], kernel: Sequence[Row]
) -> dict[str, Situation]:
    reduced, rank = values.rref()
    rows = [[j for j in range(len(states)) if reduced[i, j]] for i in range(rank)]
    alone = {row[0] for row in rows if len(row) == 1}
    touched = {j for term in terms for j in term.row}
    coupled = {j for column in kernel for j in column}
    if alone != touched - coupled:
        raise UndecidedError(NOT_THE_SPAN)
    return {name: 1 if j in alone else 2 if j in touched else 3 for j, name in enumerate(states)}


def modulo(field: Field, rows: Sequence[Row], n: int) -> nmod_mat:
    """Return the values of rows at a random point modulo a prime: their rank there is not above theirs."""
    for seed in range(_SEED, _SEED + _ATTEMPTS):
        try:
            point = SeriesPoint(field, 1, seed)
            values = [[int(point.value(row[j])[0]) if j in row else 0 for j in range(n)] for row in rows]
        except BadPointError:
            continue
        return nmod_mat(max(1, len(rows)), n, [v for row in values or [[0] * n] for v in row], PRIME)
    raise UndecidedError("no point was found at which the coefficients exist")


def _pivots(matrix: nmod_mat) -> set[int]:
    """Return the columns that are independent of those before them."""
    reduced, rank = matrix.rref()
    columns = range(matrix.ncols())
    return {next(j for j in columns if reduced[i, j]) for i in range(rank)}


def names_in(system: System) -> frozenset[str]:
    """Return the names that a new one must differ from."""
    names = {system.time, *system.state_names, *(output.name for output in system.outputs)}
    names |= {parameter.name for parameter in system.parameters}
    return frozenset(names | {function.name for function in system.functions})
