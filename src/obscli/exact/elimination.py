"""The reduced echelon form of the observable covectors, by fraction-free elimination on the fly.

A row of L may be scaled by any field element d: (dl)' + (dl)A = d(l' + lA) modulo l. So denominators are
cleared, contents stripped, and only the rows known to be independent (``saturation``) are eliminated;
what is differentiated is the reduced row w, which spans with the earlier ones the same flag as L:

    w = c l modulo earlier rows,  c ≠ 0

Every divisor (denominator, content, pivot) is logged: where none of them vanishes identically in t, and
the generators stay independent, the elimination commutes with a specialisation of the parameters.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce as fold
from typing import TYPE_CHECKING

from obscli.exact.echelon import Echelon, PolyRow, accumulate
from obscli.exact.field import common_denominator, least_common_multiple
from obscli.exact.polynomial import times


if TYPE_CHECKING:
    from collections.abc import Sequence

    from obscli.exact.exact_system import ExactSystem, Row
    from obscli.exact.polynomial import Polynomial
    from obscli.exact.saturation import Saturation


@dataclass(frozen=True, slots=True, eq=False)
class Flag:
    """The reduced echelon form of the row space of L and how it came about.

    ``rows``: pivot column → row, each zero in the other pivot columns. ``before_last``: the echelon form of
    the rows below the saturation order. ``divisors``: every polynomial divided by. ``eliminated``: whether
    that was done at all, or the row space is known to be everything.
    """

    rows: dict[int, PolyRow]
    before_last: dict[int, PolyRow]
    divisors: tuple[Polynomial, ...]
    eliminated: bool = True


def eliminate(exact: ExactSystem, saturation: Saturation, columns: Sequence[int]) -> Flag:
    """Return the reduced echelon form with pivots leftmost in the given order of the columns.

    Raises
    ------
    UndecidedError : the coefficients grow beyond what exact algebra can carry
    """
    return _Elimination(exact, columns).run(saturation)


def everything(exact: ExactSystem) -> Flag:
    """Return the reduced echelon form of a row space of full rank: every state by itself."""
    one = exact.field.one_polynomial
    return Flag({j: {j: one} for j in range(exact.n)}, {}, (), eliminated=False)


class _Elimination:
    def __init__(self, exact: ExactSystem, columns: Sequence[int]) -> None:
        self.exact = exact
        self.field = exact.field
        self.echelon = Echelon(exact.field, columns)
        self.denominators = [common_denominator(row.values(), self.field.one_polynomial) for row in exact.A]
        self.A = [self._clear(row, den) for row, den in zip(exact.A, self.denominators, strict=True)]
        for den in self.denominators:
            self.echelon.log(den)

    def run(self, saturation: Saturation) -> Flag:
        reduced: dict[tuple[int, int], PolyRow] = {}
        echelon = self.echelon
        before_last: dict[int, PolyRow] = {}
        last = -1
        for order, output in saturation.rows:
            if order != last:
                before_last, last = dict(echelon.rows), order
            row = self._start(output) if order == 0 else self._differentiate(reduced[order - 1, output])
            row = echelon.strip(echelon.reduce(row))
            reduced[order, output] = row
            echelon.insert(row)
        return Flag(echelon.rows, before_last, tuple(echelon.divisors.values()))

    def _start(self, output: int) -> PolyRow:
        row = self.exact.H[output]
        den = common_denominator(row.values(), self.field.one_polynomial)
        self.echelon.log(den)
        return self._clear(row, den)

    def _clear(self, row: Row, den: Polynomial) -> PolyRow:
        return {j: self._product(e.num, den / e.den) for j, e in row.items()}

    def _differentiate(self, row: PolyRow) -> PolyRow:
        """Return (l' + lA) times a common denominator."""
        rates = self._rates(row)
        den = self._common_denominator(row, rates)
        result: PolyRow = {}
        for k in rates:
            rate = self.field.derivative(k)
            factor = times(rate.num, den / rate.den)
            for j, entry in row.items():
                partial = entry.derivative(k)
                if not partial.is_zero():
                    accumulate(result, j, times(partial, factor))
        for i, entry in row.items():
            scaled = times(entry, den / self.denominators[i])
            for j, a in self.A[i].items():
                accumulate(result, j, times(scaled, a))
        return self.echelon.normal(result)

    def _rates(self, row: PolyRow) -> list[int]:
        """Return the generators in a row that vary in time."""
        used = {k for entry in row.values() for k, degree in enumerate(entry.degrees()) if degree > 0}
        return [k for k in sorted(used) if self.field.varies(k)]

    def _common_denominator(self, row: PolyRow, rates: list[int]) -> Polynomial:
        parts = [self.denominators[i] for i in row] + [self.field.derivative(k).den for k in rates]
        den: Polynomial = fold(least_common_multiple, parts, self.field.one_polynomial)
        self.echelon.log(den)
        return den

    def _product(self, a: Polynomial, b: Polynomial) -> Polynomial:
        return self.field.reduce(times(a, b))
