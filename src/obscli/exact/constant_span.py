"""Linear forms with exponential polynomials as coefficients, as vectors over the constants.

    l(t) x = Σ c_(i,f) f(t) x_i,     D l = l' + l A,     c constant, f a mode, x_i a state

A column stands for a pair (state, mode). D is linear over the constants: it is known by what it makes of
each column.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from obscli.exact.mode import mode_product
from obscli.exact.rows import combined


if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from obscli.exact.exact_system import Row
    from obscli.exact.exponential_polynomial import ExponentialPolynomial
    from obscli.exact.field import Element
    from obscli.exact.mode import Mode
    from obscli.exact.modes import Modes


class Forms:
    """Columns (state, mode) of one system, and D on them."""

    def __init__(
        self,
        modes: Modes,
        A: tuple[Mapping[int, ExponentialPolynomial], ...],
        H: tuple[Mapping[int, ExponentialPolynomial], ...],
    ) -> None:
        self.modes, self.field, self.A = modes, modes.field, A
        self.columns: list[tuple[int, Mode]] = []
        self._index: dict[tuple[int, Mode], int] = {}
        self._rates: dict[int, Row] = {}
        self.moving = tuple(i for i, row in enumerate(A) if row)
        self.H = tuple(self._row(row) for row in H)

    def _row(self, row: Mapping[int, ExponentialPolynomial]) -> dict[int, Element]:
        return {self.column(j, f): c for j, entry in row.items() for f, c in entry.items()}

    def column(self, state: int, mode: Mode) -> int:
        """Return the column of a pair."""
        known = self._index.get((state, mode))
        if known is None:
            known = self._index[state, mode] = len(self.columns)
            self.columns.append((state, mode))
        return known

    def state(self, i: int) -> Row:
        """Return a state as a form."""
        return {self.column(i, self.modes.one): self.field.one}

    def column_rate(self, column: int) -> Row:
        """Return D of one column: f' x_i + f Σ_j a_ij x_j."""
        known = self._rates.get(column)
        if known is None:
            known = self._rates[column] = self._column_rate(column)
        return known

    def _column_rate(self, column: int) -> Row:
        state, mode = self.columns[column]
        total: dict[int, Element] = {}
        for other, coefficient in self.modes.rate(mode):
            _add(total, self.column(state, other), coefficient)
        for j, entry in self.A[state].items():
            for other, coefficient in entry.items():
                for product, factor in mode_product(mode, other):
                    _add(total, self.column(j, product), coefficient * self.field.rational(factor))
        return {k: entry for k, entry in total.items() if entry}

    def rate(self, form: Row) -> dict[int, Element]:
        """Return D l."""
        return combined(self.field, [(entry, self.column_rate(k)) for k, entry in form.items()])

    @property
    def closes(self) -> bool:
        """Whether moving states move by constant coefficients among themselves: every space closes then."""
        one = {self.modes.one}
        return all(
            set(entry) == one for i in self.moving for j, entry in self.A[i].items() if j in self.moving
        )

    def reached(self, start: Iterable[int]) -> set[int]:
        """Return the columns that D leads to from some, again and again; only where every space closes."""
        found = set(start)
        waiting = sorted(found)
        while waiting:
            fresh = set(self.column_rate(waiting.pop())) - found
            found |= fresh
            waiting += sorted(fresh)
        return found

    def place(self, column: int) -> tuple[object, ...]:
        """Where a column stands among others: moving states first, then by mode, then by state."""
        state, mode = self.columns[column]
        plain = mode == self.modes.one and state in self.moving
        return (not plain, mode.place, state)

    def order(self, columns: Iterable[int]) -> list[int]:
        """Return columns in the order in which pivots are sought."""
        return sorted(columns, key=self.place)

    def over_the_field(self, form: Row) -> dict[int, Element]:
        """Return a form by states, with elements of the field as coefficients."""
        one = self.field.one
        return combined(
            self.field,
            [
                (c * self.modes.element(self.columns[k][1]), {self.columns[k][0]: one})
                for k, c in form.items()
            ],
        )


def _add(total: dict[int, Element], column: int, term: Element) -> None:
    total[column] = total[column] + term if column in total else term
