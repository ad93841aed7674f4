"""Reduced echelon forms of sparse polynomial rows, fraction-free, one row at a time.

    row ← m row - Σ_p (m row_p / b_p) b        p the pivots, m = lcm(b_p / gcd(b_p, row_p))

The form is kept reduced (each row zero in the other pivot columns), so one pass over the pivots suffices;
contents are stripped after every step. Every divisor (content, pivot) is logged.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

from obscli.exact.errors import UndecidedError
from obscli.exact.field import Field, common_denominator, least_common_multiple
from obscli.exact.polynomial import MOST_TERMS, common_factor, require_small, times


if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from obscli.exact.field import Element
    from obscli.exact.polynomial import Polynomial

#: The squares of the numbers of terms of all entries computed may add up to this, and to this much more
#: for every state; it takes some seconds (16 IMUs, 339 states, come to 8 million).
_MOST_WORK, _MOST_WORK_PER_STATE = 60_000_000, 200_000

#: A sparse row of polynomials by column.
PolyRow: TypeAlias = "dict[int, Polynomial]"


class Echelon:
    """A growing reduced echelon form with pivots leftmost in a given order of the columns."""

    def __init__(self, field: Field, columns: Sequence[int]) -> None:
        self.field = field
        self.rows: dict[int, PolyRow] = {}
        self.divisors: dict[str, Polynomial] = {}
        self._work = 0
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
            common = common_factor(pivot, row[p])
            quotients[p] = (row[p] / common, pivot / common)
            multiplier = least_common_multiple(multiplier, pivot / common)
        result = {j: times(entry, multiplier) for j, entry in row.items() if j not in quotients}
        for p, (above, below) in quotients.items():
            factor = times(-above, multiplier / below)
            for j, entry in self.rows[p].items():
                if j != p:
                    accumulate(result, j, times(entry, factor))
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
        common = common_factor(other[pivot], row[pivot])
        mine, theirs = row[pivot] / common, -(other[pivot] / common)
        result = {j: times(entry, mine) for j, entry in other.items() if j != pivot}
        for j, entry in row.items():
            if j != pivot:
                accumulate(result, j, times(entry, theirs))
        return self.normal(result)

    def _rationalise(self, row: PolyRow, pivot: int) -> PolyRow:
        """Free the pivot of quadratic roots, which makes the printed row canonical."""
        if not self.field.has_roots:
            return row
        multiplier = self.field.rationaliser(row[pivot])
        if multiplier is None:
            return row
        return self.strip(self.normal({j: times(entry, multiplier) for j, entry in row.items()}))

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
            content = entry if content is None else common_factor(content, entry)
            if content.is_one():
                return None
        if content is None:
            raise UndecidedError("a row found independent modulo a prime vanished exactly")
        return content

    def normal(self, row: PolyRow) -> PolyRow:
        """Return the row modulo the relations of the field, without zeros."""
        if self.field.has_roots:
            row = {j: self.field.reduce(entry) for j, entry in row.items()}
        require_small(max(map(len, row.values()), default=0), MOST_TERMS)
        self._work += sum(len(entry) ** 2 for entry in row.values())
        require_small(self._work, _MOST_WORK + _MOST_WORK_PER_STATE * len(self._place))
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


def polynomial_row(field: Field, row: Mapping[int, Element]) -> PolyRow:
    """Return a row of field elements times their common denominator."""
    den = common_denominator(row.values(), field.one_polynomial)
    return {j: times(e.num, den / e.den) for j, e in row.items()}


def accumulate(row: PolyRow, column: int, term: Polynomial) -> None:
    """Add a term to an entry of a row."""
    row[column] = row[column] + term if column in row else term
