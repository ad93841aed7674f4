"""Reduced echelon forms of sparse polynomial rows, fraction-free, one row at a time.

    row ← m row - Σ_p (m row_p / b_p) b        p the pivots, m = lcm(b_p / gcd(b_p, row_p))

The form is kept reduced (each row zero in the other pivot columns), so one pass over the pivots suffices;
contents are stripped after every step. Every divisor (content, pivot) is logged.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

from obscli.exact.errors import UndecidedError
from obscli.exact.field import MOST_TERMS, Field, least_common_multiple


if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from obscli.exact.polynomial import Polynomial

#: A sparse row of polynomials by column.
PolyRow: TypeAlias = "dict[int, Polynomial]"


class Echelon:
    """A growing reduced echelon form with pivots leftmost in a given order of the columns."""

    def __init__(self, field: Field, columns: Sequence[int]) -> None:
        self.field = field
        self.rows: dict[int, PolyRow] = {}
        self.divisors: dict[str, Polynomial] = {}
        self._place = {column: k for k, column in enumerate(columns)}

    def reduce(self, row: PolyRow) -> PolyRow:
        """Return the row made zero in all pivot columns: m l - Σ (m l_p / b_p) b."""
        pivots = [p for p in row if p in self.rows]
        if not pivots:
            return row
        quotients = {}
        multiplier = self.field.one_polynomial
        for p in pivots:
            pivot = self.rows[p][p]
            common = pivot.gcd(row[p])
            quotients[p] = (row[p] / common, pivot / common)
            multiplier = least_common_multiple(multiplier, pivot / common)
        result = {j: entry * multiplier for j, entry in row.items() if j not in quotients}
        for p, (above, below) in quotients.items():
            factor = -above * (multiplier / below)
            for j, entry in self.rows[p].items():
                if j != p:
                    accumulate(result, j, entry * factor)
        return self.normal(result)

    def insert(self, row: PolyRow) -> None:
        """Take in a reduced, nonzero row, and clear its pivot column in the others."""
        pivot = min(row, key=self._place.__getitem__)
        row = self._rationalise(row, pivot)
        self.log(row[pivot])
        for p, other in self.rows.items():
            if pivot in other:
                self.rows[p] = self.strip(self._rationalise(self._combine(other, row, pivot), p))
        self.rows[pivot] = row

    def _combine(self, other: PolyRow, row: PolyRow, pivot: int) -> PolyRow:
        common = other[pivot].gcd(row[pivot])
        mine, theirs = row[pivot] / common, -(other[pivot] / common)
        result = {j: entry * mine for j, entry in other.items() if j != pivot}
        for j, entry in row.items():
            if j != pivot:
                accumulate(result, j, entry * theirs)
        return self.normal(result)

    def _rationalise(self, row: PolyRow, pivot: int) -> PolyRow:
        """Free the pivot of quadratic roots, which makes the printed row canonical."""
        if not self.field.has_roots:
            return row
        multiplier = self.field.rationaliser(row[pivot])
        if multiplier is None:
            return row
        return self.strip(self.normal({j: entry * multiplier for j, entry in row.items()}))

    def strip(self, row: PolyRow) -> PolyRow:
        """Return the row divided by its content."""
        content = self._content(row)
        if content is None:
            return row
        self.log(content)
        return {j: entry / content for j, entry in row.items()}

    def _content(self, row: PolyRow) -> Polynomial | None:
        content = None
        for entry in sorted(row.values(), key=len):
            content = entry if content is None else content.gcd(entry)
            if content.is_one():
                return None
        if content is None:
            raise UndecidedError("a row found independent modulo a prime vanished exactly")
        return content

    def normal(self, row: PolyRow) -> PolyRow:
        """Return the row modulo the relations of the field, without zeros."""
        if self.field.has_roots:
            row = {j: self.field.reduce(entry) for j, entry in row.items()}
        if any(len(entry) > MOST_TERMS for entry in row.values()):
            raise UndecidedError("the coefficients grew too large for exact algebra")
        return {j: entry for j, entry in row.items() if not entry.is_zero()}

    def log(self, divisor: Polynomial) -> None:
        """Remember a divisor."""
        if not divisor.is_constant():
            self.divisors.setdefault(str(divisor), divisor)


def reduced_echelon(field: Field, rows: Iterable[PolyRow], columns: Sequence[int]) -> dict[int, PolyRow]:
    """Return the reduced echelon form of rows of any rank: pivot column → row."""
    echelon = Echelon(field, columns)
    for row in rows:
        rest = echelon.reduce(row)
        if rest:
            echelon.insert(echelon.strip(rest))
    return echelon.rows


def accumulate(row: PolyRow, column: int, term: Polynomial) -> None:
    """Add a term to an entry of a row."""
    row[column] = row[column] + term if column in row else term
