"""The smallest space over the constants that contains given forms and, with each form l, D l = l' + l A.

    D v = Σ_p (D v)_p/b_p[p] b_p        p the pivots of the reduced echelon form b

That a space is closed is this identity, exactly. Whether one closes at all is found before, modulo a prime,
with a dimension that it has at least. Forms with plain coefficients that are in the space modulo the prime
are taken first, which keeps the others small: where the dimension stays the same, so does the space.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Final

from flint import nmod_mat

from obscli.exact.echelon import Echelon, polynomial_row
from obscli.exact.rows import combined, field_row
from obscli.exact.series import PRIME


if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from obscli.exact.closure_screen import Values
    from obscli.exact.constant_span import Forms
    from obscli.exact.echelon import PolyRow
    from obscli.exact.exact_system import Row
    from obscli.exact.field import Element

#: Numerators and denominators of coefficients that count as plain.
_LARGEST: Final = 64


@dataclass(frozen=True, eq=False)
class Span:
    """A closed space of forms by its reduced echelon form: pivot → row, pivots in order."""

    forms: Forms
    rows: dict[int, PolyRow]

    @property
    def dimension(self) -> int:
        """Its dimension over the constants."""
        return len(self.rows)

    @cached_property
    def basis(self) -> dict[int, Row]:
        """The rows as forms, by pivot."""
        return {p: field_row(self.forms.field, row) for p, row in self.rows.items()}

    def coordinates(self, form: Row) -> dict[int, Element] | None:
        """Return a form by the rows, by pivot; None: it is not in the space."""
        field = self.forms.field
        found = {p: entry / self.basis[p][p] for p, entry in form.items() if p in self.basis}
        rest = combined(field, [(field.one, form), *((-c, self.basis[p]) for p, c in found.items())])
        return None if rest else found


def closure(forms: Forms, rows: Sequence[Row], screened: Mapping[int, Values]) -> Span:
    """Return the smallest closed space with given forms.

    Parameters
    ----------
    screened : an echelon form of it at the random point of the screen

    Raises
    ------
    UndecidedError : the coefficients grow too large
    """
    found = _closed(forms, [*_plain(forms, screened), *rows])
    return found if found.dimension == len(screened) else _closed(forms, rows)


def _closed(forms: Forms, rows: Sequence[Row]) -> Span:
    field = forms.field
    echelon = Echelon(field, forms.order(range(len(forms.columns))))
    waiting = list(rows)
    while waiting:
        rest = echelon.reduce(polynomial_row(field, waiting.pop(0)))
        if rest:
            rest = echelon.strip(rest)
            echelon.insert(rest)
            waiting.append(forms.rate(field_row(field, rest)))
    return Span(forms, {p: echelon.rows[p] for p in forms.order(echelon.rows)})


def _plain(forms: Forms, screened: Mapping[int, Values]) -> Iterator[Row]:
    """Yield the rows of the reduced echelon form, modulo the prime, with small rational numbers in them."""
    columns = forms.order({k for row in screened.values() for k in row})
    place = {column: k for k, column in enumerate(columns)}
    matrix = nmod_mat(max(1, len(screened)), max(1, len(columns)), PRIME)
    for i, row in enumerate(screened.values()):
        for column, value in row.items():
            matrix[i, place[column]] = value
    reduced, rank = matrix.rref()
    for i in range(rank):
        values = {column: int(reduced[i, k]) for k, column in enumerate(columns)}
        entries = {column: _small(value) for column, value in values.items() if value}
        if None not in entries.values():
            yield {column: forms.field.rational(entry) for column, entry in entries.items() if entry}


def _small(value: int) -> Fraction | None:
    """Return the rational number of few digits that a value modulo the prime stands for, if there is one."""
    for below in range(1, _LARGEST + 1):
        above = value * below % PRIME
        above = above - PRIME if above > PRIME // 2 else above
        if abs(above) <= _LARGEST:
            return Fraction(above, below)
    return None
