"""Verdicts for states and quantities, read off a reduced basis.

The bipartite graph states × combinations of a reduced basis has connected components that do not depend
on the choice of pivots (they are the components of the matroid of the columns).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from obscli.exact.errors import UndecidedError
from obscli.exact.finding import LinearFormVerdict, QuantityVerdict, StateVerdict
from obscli.exact.nonzero import first_nonzero
from obscli.exact.rows import dot, field_row


if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from obscli.exact.echelon import PolyRow
    from obscli.exact.exact_system import ExactSystem
    from obscli.model.system import Quantity


def groups(rows: Mapping[int, PolyRow]) -> list[set[int]]:
    """Return the connected components of states that share combinations, singletons included."""
    components: list[set[int]] = []
    for row in rows.values():
        joined = set(row)
        apart = []
        for component in components:
            if component & joined:
                joined |= component
            else:
                apart.append(component)
        components = [*apart, joined]
    return components


def state_verdicts(names: Sequence[str], components: Sequence[set[int]]) -> dict[str, StateVerdict]:
    """A state alone in its component is observable, with others coupled, in no component unobservable."""
    verdicts: dict[str, StateVerdict] = dict.fromkeys(names, "unobservable")
    for component in components:
        for j in component:
            verdicts[names[j]] = "observable" if len(component) == 1 else "coupled"
    return verdicts


def quantity_verdict(
    quantity: Quantity,
    exact: ExactSystem,
    kernel: Mapping[int, PolyRow],
    components: Sequence[set[int]],
) -> QuantityVerdict:
    """A quantity q is observable iff q N = 0; coupled where one of its states enters a combination."""
    field, names = exact.field, exact.system.state_names
    row = exact.row(quantity.coefficients)
    products = [dot(field, row, field_row(field, column)) for column in kernel.values()]
    group = tuple(names[j] for j in sorted(j for c in components if c & row.keys() for j in c))
    verdict: LinearFormVerdict = "coupled" if group else "unobservable"
    try:
        if first_nonzero(exact.interpreter, products) is None:
            verdict = "observable"
    except UndecidedError:
        verdict = "undecided"
    return QuantityVerdict(quantity.name, quantity.coefficients, verdict, group)
