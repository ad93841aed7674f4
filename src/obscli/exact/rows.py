"""Rows and columns over the field: made of polynomials, multiplied; the drift of a direction."""

from __future__ import annotations

from typing import TYPE_CHECKING

from obscli.exact.field import Element


if TYPE_CHECKING:
    from obscli.exact.echelon import PolyRow
    from obscli.exact.exact_system import ExactSystem, Row
    from obscli.exact.field import Field


def drift(exact: ExactSystem, column: Row) -> dict[int, Element]:
    """Return v' - A v for a direction v."""
    field = exact.field
    result = {i: derivative for i, e in column.items() if (derivative := field.derive(e))}
    for i, row in enumerate(exact.A):
        product = dot(field, row, column)
        if product:
            rest = result.get(i, field.zero) - product
            if rest:
                result[i] = rest
            else:
                result.pop(i, None)
    return result


def dot(field: Field, row: Row, column: Row) -> Element:
    """Return the product of a row and a column."""
    total = field.zero
    if len(row) > len(column):
        row, column = column, row
    for j, element in row.items():
        if j in column:
            total = total + element * column[j]
    return total


def field_row(field: Field, row: PolyRow) -> dict[int, Element]:
    """Return a row of polynomials as a row of field elements."""
    return {j: Element(field, entry, field.one_polynomial) for j, entry in row.items()}
