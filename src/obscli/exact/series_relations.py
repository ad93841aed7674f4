"""The relations of a system that varies in time, from a power series at the instant t0 of x0.

    y_i(t) = Σ_k (t − t0)^k/k! d_ikᵀ x0,      d_ik the rows of L_k(t0)

At almost every instant the blocks up to the order at which L saturates span all others. At a particular one,
such as the start of the interval, later blocks may be needed; those of an analytic system do reach the rank,
at every instant at which its coefficients exist, because x0 is known at one instant if it is at another.
"""

from __future__ import annotations

from itertools import islice
from math import factorial
from typing import TYPE_CHECKING, Final

from obscli.exact.at_instant import AtInstant
from obscli.exact.errors import JetOverflowError, UndecidedError, UndefinedError
from obscli.exact.relation_terms import Term, modulo, names_in, related
from obscli.exact.relations_finding import Relations
from obscli.exact.restore import Restorer
from obscli.exact.rows import field_row
from obscli.exact.tower import tower
from obscli.model.expression import (
    ONE,
    ZERO,
    Symbol,
    TimeDerivative,
    add,
    divide,
    negate,
    number,
    power,
    substitute,
    symbols,
)


if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from obscli.exact.exact_system import Row
    from obscli.exact.field import Element
    from obscli.exact.polynomial import Polynomial
    from obscli.exact.prove import Proof
    from obscli.model.expression import Expression
    from obscli.model.system import System

#: At a particular instant so many blocks beyond the order of saturation are looked at.
_MOST_FURTHER: Final = 8


def series_relations(proof: Proof) -> Relations:
    """Return the relations at the start of the interval, else at 0, else at an instant t0 left open."""
    generic = _at_any_instant(proof)
    if not _depends_on_time(proof):
        return generic
    interval = proof.exact.system.interval
    start = interval.start if interval is not None else None
    for instant in (ZERO,) if start is None else (start, ZERO):
        try:
            return _at_instant(proof, instant, generic)
        except (UndefinedError, UndecidedError, JetOverflowError):
            continue
    return generic


def _depends_on_time(proof: Proof) -> bool:
    time = proof.exact.system.time
    return any(time in symbols(generator.meaning) for generator in proof.exact.field.generators)


def _at_any_instant(proof: Proof) -> Relations:
    exact, states = proof.exact, proof.exact.system.state_names
    instant = Symbol(_name_of_instant(exact.system))
    blocks = list(islice(tower(exact), proof.order + 1))
    kernel = [field_row(exact.field, column) for column in proof.kernel.columns.values()]
    given = _terms(exact.system, instant, blocks)
    terms = related(exact.field, states, _AtSymbol(proof, instant), given, kernel, proof.rank)
    return Relations(exact=False, relations=terms.relations, situations=terms.situations, instant=instant)


def _at_instant(proof: Proof, instant: Expression, generic: Relations) -> Relations:
    """Return the relations at one instant, with as many blocks as it takes to reach the rank.

    Raises
    ------
    UndefinedError : a coefficient does not exist there
    UndecidedError : the rank is not reached
    """
    exact, system = proof.exact, proof.exact.system
    there = AtInstant(exact, instant)
    blocks: list[tuple[Row, ...]] = []
    for block in islice(tower(exact), proof.order + 1 + _MOST_FURTHER):
        blocks.append(tuple(there.row(row) for row in block))
        if len(blocks) > proof.order and _rank(there, blocks, exact.n) == proof.rank:
            break
    kernel = [there.row(field_row(exact.field, column)) for column in proof.kernel.columns.values()]
    given = _terms(system, instant, blocks)
    writer = Restorer(there.interpreter)
    terms = related(there.field, system.state_names, writer, given, kernel, proof.rank)
    found = terms.situations
    differing = tuple(state for state, one in found.items() if one != generic.situations[state])
    return Relations(
        exact=False, relations=terms.relations, situations=found, instant=instant, differing=differing
    )


def _rank(there: AtInstant, blocks: Sequence[Sequence[Row]], n: int) -> int:
    rank: int = modulo(there.field, [row for block in blocks for row in block if row], n).rank()
    return rank


def _terms(system: System, instant: Expression, blocks: Sequence[Sequence[Row]]) -> Iterator[Term]:
    elapsed = add(Symbol(system.time), negate(instant))
    for k, block in enumerate(blocks):
        function = divide(power(elapsed, k), number(factorial(k))) if k else ONE
        for output, row in zip(system.outputs, block, strict=True):
            yield Term(function, output.name, row)


def _name_of_instant(system: System) -> str:
    """Return ``t0``, or what comes next to it where something else has that name."""
    taken = names_in(system)
    name = f"{system.time}0"
    while name in taken:
        name += "0"
    return name


class _AtSymbol:
    """Writes elements as expressions with t0 in place of the time."""

    def __init__(self, proof: Proof, instant: Symbol) -> None:
        system = proof.exact.system
        self._restorer = proof.restorer
        self._values = {system.time: instant}
        self._derive = TimeDerivative(system.time, {}, frozenset())

    def element(self, element: Element) -> Expression:
        """Return an element as it is."""
        return self._written(self._restorer.element(element))

    def row(self, row: Mapping[int, Polynomial]) -> dict[int, Expression]:
        """Return a row up to a factor."""
        return {j: self._written(entry) for j, entry in self._restorer.row(row).items()}

    def _written(self, expression: Expression) -> Expression:
        return substitute(expression, self._values, self._derive)
