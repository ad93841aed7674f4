"""How many rows of L can be independent up to an order, without eliminating them.

    r_k = rank [L_0; …; L_k],    r_{k+1} − r_k ≤ r_k − r_{k−1}

for l ↦ l' + l A maps the span of the rows up to k, modulo that up to k − 1, onto that up to k + 1 modulo k;
so an output whose derivative is a combination of outputs, as that of a position beside its velocity, brings
one row, and every other output at most one row an order.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from obscli.exact.rows import rate_of


if TYPE_CHECKING:
    from obscli.exact.exact_system import ExactSystem, Row
    from obscli.exact.field import Element


def most_rows(exact: ExactSystem, order: int) -> int:
    """Return a bound on the number of independent rows of L up to an order: m + order (m − s).

    s is the number of outputs whose derivative is a combination of outputs, exactly.

    Raises
    ------
    UndecidedError : the coefficients of H grow too large
    JetOverflowError : more derivatives of a function are needed than the field holds
    """
    echelon: dict[int, dict[int, Element]] = {}
    for row in exact.H:
        rest = _reduced(exact, row, echelon)
        if rest:
            echelon[min(rest)] = rest
    inside = sum(not _reduced(exact, rate_of(exact, row), echelon) for row in exact.H)
    return len(exact.H) + order * (len(exact.H) - inside)


def _reduced(exact: ExactSystem, row: Row, echelon: dict[int, dict[int, Element]]) -> dict[int, Element]:
    """Return the row less the multiples of the rows of the echelon form that clear their pivots."""
    rest = dict(row)
    for pivot, other in echelon.items():
        if pivot not in rest:
            continue
        factor = rest[pivot] / other[pivot]
        for j, entry in other.items():
            rest[j] = rest.get(j, exact.field.zero) - factor * entry
        rest = {j: entry for j, entry in rest.items() if entry}
    return rest
