"""Rows and columns over the field: made of polynomials, multiplied, added; how forms and directions move."""

from __future__ import annotations

from typing import TYPE_CHECKING

from obscli.exact.field import Element


if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from obscli.exact.echelon import PolyRow
    from obscli.exact.exact_system import ExactSystem, Row
    from obscli.exact.field import Field


def rate_of(exact: ExactSystem, row: Row) -> dict[int, Element]:
    """Return l' + l A, the rate of change of a linear form l x.

    Of a discrete-time system l F, the form that it is a step earlier.
    """
    moving = {j: derivative for j, e in row.items() if (derivative := exact.field.derive(e))}
    return combined(exact.field, [(exact.field.one, moving), *((e, exact.A[i]) for i, e in row.items())])


def drift(exact: ExactSystem, column: Row) -> dict[int, Element]:
    """Return v' - A v for a direction v; of a discrete-time system F v, where it goes."""
    field = exact.field
    if exact.system.discrete:
        return {i: product for i, row in enumerate(exact.A) if (product := dot(field, row, column))}
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


def is_solution(exact: ExactSystem, column: Row) -> bool:
    """Whether a direction v(t) is a solution by itself: v' = A v, or F v = v where v is constant."""
    moved = drift(exact, column)
    return moved == {i: e for i, e in column.items() if e} if exact.system.discrete else not moved


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


def combined(field: Field, terms: Iterable[tuple[Element, Row]]) -> dict[int, Element]:
    """Return Σ c v, without zeros."""
    total: dict[int, Element] = {}
    for factor, row in terms:
        for j, entry in row.items():
            total[j] = total.get(j, field.zero) + factor * entry
    return {j: entry for j, entry in total.items() if entry}


def transpose(rows: Iterable[Mapping[int, Element]], columns: int) -> tuple[Row, ...]:
    """Return the transpose of a matrix of so many columns, as sparse rows."""
    result: list[dict[int, Element]] = [{} for _ in range(columns)]
    for i, row in enumerate(rows):
        for j, entry in row.items():
            result[j][i] = entry
    return tuple(result)
