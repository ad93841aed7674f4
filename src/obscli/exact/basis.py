"""Bases of the observable covectors: reduced echelon, sparse, or completed from rows a user prefers."""

from __future__ import annotations

import random
from typing import TYPE_CHECKING

from obscli.exact.echelon import polynomial_row, reduced_echelon
from obscli.exact.nonzero import first_nonzero, require_independent
from obscli.exact.rows import dot, field_row


if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from obscli.exact.echelon import PolyRow
    from obscli.exact.exact_system import ExactSystem
    from obscli.model.system import Quantity

_ORDERS = 24


def sparse_basis(exact: ExactSystem, rows: Mapping[int, PolyRow]) -> list[PolyRow]:
    """Return independent combinations with few states each, chosen greedily.

    Rows of reduced echelon forms are combinations of minimal support; those of several column orders
    are sorted by length and taken while they are independent.
    """
    source = random.Random(0)  # noqa: S311  (an order to try, no secret)
    candidates = list(rows.values())
    columns = list(range(exact.n))
    for attempt in range(_ORDERS if len(rows) * exact.n <= 4000 else 2):
        order = columns[::-1] if attempt == 0 else source.sample(columns, len(columns))
        candidates += reduced_echelon(exact.field, list(rows.values()), order).values()
    unique = {tuple(sorted(row)): row for row in reversed(candidates)}
    ranked = sorted(unique.values(), key=lambda row: (len(row), sum(map(len, row.values())), sorted(row)))
    return _proved(exact, _independent(exact, ranked, len(rows)))


def preferred_basis(
    exact: ExactSystem,
    rows: Mapping[int, PolyRow],
    kernel: Mapping[int, PolyRow],
    preferred: Sequence[Quantity],
) -> tuple[list[PolyRow], list[str]]:
    """Return the user's rows that are observable, completed to a basis, and remarks on those left out."""
    columns = [field_row(exact.field, column) for column in kernel.values()]
    chosen: list[PolyRow] = []
    notes: list[str] = []
    for quantity in preferred:
        elements = exact.row(quantity.coefficients)
        products = [dot(exact.field, elements, column) for column in columns]
        if not elements or first_nonzero(exact.interpreter, products) is not None:
            notes.append(f"{quantity.text or quantity.name} is not observable and was left out of the basis")
            continue
        row = polynomial_row(exact.field, elements)
        if len(_independent(exact, [*chosen, row], len(chosen) + 1)) == len(chosen):
            notes.append(f"{quantity.text or quantity.name} depends on the rows before it and was left out")
            continue
        chosen.append(row)
    return _proved(exact, _independent(exact, [*chosen, *rows.values()], len(rows))), notes


def _proved(exact: ExactSystem, rows: list[PolyRow]) -> list[PolyRow]:
    """Return the rows, proved independent."""
    require_independent(exact.interpreter, [field_row(exact.field, row) for row in rows])
    return rows


def _independent(exact: ExactSystem, candidates: Sequence[PolyRow], rank: int) -> list[PolyRow]:
    """Take candidates from the front while they are independent, until there are ``rank`` of them."""
    taken: list[PolyRow] = []
    echelon: dict[int, PolyRow] = {}
    for row in candidates:
        if len(taken) == rank:
            break
        larger = reduced_echelon(exact.field, [*echelon.values(), row], range(exact.n))
        if len(larger) > len(taken):
            taken.append(row)
            echelon = larger
    return taken
