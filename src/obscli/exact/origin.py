"""Which row of the observability matrix first yields a combination.

The independent rows of L, by order and output, span a growing flag. A combination s = Σ c_i L_i first
lies in the span at the last i with c_i ≠ 0; the c_i are computed at a random point modulo a prime.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from obscli.exact.rows import field_row
from obscli.exact.saturation import independent_values
from obscli.exact.series import PRIME, SeriesPoint


if TYPE_CHECKING:
    from collections.abc import Sequence

    from obscli.exact.echelon import PolyRow
    from obscli.exact.exact_system import ExactSystem
    from obscli.exact.saturation import Saturation


def first_rows(exact: ExactSystem, saturation: Saturation, rows: Sequence[PolyRow]) -> list[tuple[int, int]]:
    """Return (order, output index) for each combination."""
    point, values = independent_values(exact, saturation)
    flag = _Flag(values)
    return [saturation.rows[flag.last(_at(point, exact, row))] for row in rows]


def _at(point: SeriesPoint, exact: ExactSystem, row: PolyRow) -> dict[int, int]:
    return {j: int(point.value(element)[0]) for j, element in field_row(exact.field, row).items()}


class _Flag:
    """An echelon form of rows entered one after the other, that knows the last row a vector needs."""

    def __init__(self, rows: Sequence[dict[int, int]]) -> None:
        self._echelon: dict[int, tuple[int, dict[int, int]]] = {}
        for k, row in enumerate(rows):
            rest, _ = self._reduce(row)
            pivot = min(rest)
            inverse = pow(rest[pivot], -1, PRIME)
            self._echelon[pivot] = (k, {j: v * inverse % PRIME for j, v in rest.items()})

    def last(self, row: dict[int, int]) -> int:
        """Return the index of the last entered row that a vector of the span needs."""
        return self._reduce(row)[1]

    def _reduce(self, row: dict[int, int]) -> tuple[dict[int, int], int]:
        row = {j: value for j, value in row.items() if value}
        last = 0
        done: dict[int, int] = {}
        while row:
            pivot = min(row)
            if pivot not in self._echelon:
                done[pivot] = row.pop(pivot)
                continue
            k, other = self._echelon[pivot]
            last = max(last, k)
            factor = row[pivot]
            for j, value in other.items():
                rest = (row.get(j, 0) - factor * value) % PRIME
                if rest:
                    row[j] = rest
                else:
                    row.pop(j, None)
        return done, last
