"""The unobservable directions, and the exact proof that there are at least so many.

From a reduced echelon form with pivots b_p the kernel has one column per free state f:

    N_f = m e_f - Σ_p (m b_p[f] / b_p[p]) e_p

H N = 0 and N' - A N = N X imply L_k N = 0 for all k:  L_{k+1} N = (L_k N)' - L_k (N' - A N).
Of a discrete-time system H N = 0 and F N = N X do:  L_{k+1} N = L_k F N.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from obscli.exact.errors import UndecidedError
from obscli.exact.field import Element, Field, least_common_multiple
from obscli.exact.polynomial import common_factor, times
from obscli.exact.rows import dot, drift, field_row


if TYPE_CHECKING:
    from collections.abc import Sequence

    from obscli.exact.echelon import PolyRow
    from obscli.exact.exact_system import ExactSystem


@dataclass(frozen=True, slots=True, eq=False)
class Kernel:
    """Columns of N by free state, and X with N' - A N = N X, or F N = N X (sparse columns by free state)."""

    columns: dict[int, PolyRow]
    multiplier: dict[int, dict[int, Element]]


def kernel_columns(field: Field, rows: dict[int, PolyRow], columns: Sequence[int]) -> dict[int, PolyRow]:
    """Return the kernel of a reduced echelon form, one primitive polynomial column per free state."""
    return {free: _column(field, rows, free) for free in columns if free not in rows}


def _column(field: Field, rows: dict[int, PolyRow], free: int) -> PolyRow:
    involved = {p: row for p, row in rows.items() if free in row}
    quotients = {}
    multiple = field.one_polynomial
    for p, row in involved.items():
        common = common_factor(row[p], row[free])
        quotients[p] = (row[free] / common, row[p] / common)
        multiple = least_common_multiple(multiple, row[p] / common)
    column = {p: field.reduce(times(-above, multiple / below)) for p, (above, below) in quotients.items()}
    column[free] = multiple
    return column


def invariant_kernel(exact: ExactSystem, columns: dict[int, PolyRow]) -> Kernel:
    """Prove H N = 0 and N' - A N = N X, and return X.

    Raises
    ------
    UndecidedError : an identity fails (the modular screen dropped a row: practically impossible)
    """
    field = exact.field
    elements = {f: field_row(field, column) for f, column in columns.items()}
    for column in elements.values():
        if any(dot(field, row, column) for row in exact.H):
            raise UndecidedError("the proof of the upper bound failed: H N is not zero")
    multiplier = {f: _multiplier(exact, elements, f) for f in elements}
    return Kernel(columns, multiplier)


def _multiplier(exact: ExactSystem, elements: dict[int, dict[int, Element]], free: int) -> dict[int, Element]:
    rest = drift(exact, elements[free])
    x = {f: rest[f] / column[f] for f, column in elements.items() if f in rest}
    for f, factor in x.items():
        for i, entry in elements[f].items():
            rest[i] = rest.get(i, exact.field.zero) - factor * entry
    if any(rest.values()):
        raise UndecidedError("the proof of the upper bound failed: the kernel is not invariant")
    return x
