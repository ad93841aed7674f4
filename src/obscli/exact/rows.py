"""Rows and columns over the field: their product, and the drift of a direction."""

from __future__ import annotations

from typing import TYPE_CHECKING


if TYPE_CHECKING:
    from obscli.exact.exact_system import ExactSystem, Row
    from obscli.exact.field import Element, Field


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
