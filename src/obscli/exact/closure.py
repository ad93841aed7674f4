"""The smallest space over the constants that contains given forms and, with each form l, D l = l' + l A.

    D v = Σ_p (D v)_p/b_p[p] b_p        p the pivots of the reduced echelon form b

That a space is closed is this identity, exactly. Whether one closes at all is found before, modulo a prime.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from obscli.exact.echelon import Echelon, polynomial_row
from obscli.exact.rows import combined, field_row


if TYPE_CHECKING:
    from collections.abc import Sequence

    from obscli.exact.constant_span import Forms
    from obscli.exact.echelon import PolyRow
    from obscli.exact.exact_system import Row
    from obscli.exact.field import Element


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


def closure(forms: Forms, rows: Sequence[Row], dimension: int) -> Span:
    """Return the smallest closed space with given forms.

    Parameters
    ----------
    dimension : that it has at least, as the screen finds it; all its columns were met there

    Raises
    ------
    UndecidedError : the coefficients grow too large
    """
    field = forms.field
    reached = forms.reached(k for row in rows for k in row) if forms.closes else None
    if reached is not None and len(reached) == dimension:  # so many independent forms of so many columns
        return Span(forms, {k: {k: field.one_polynomial} for k in forms.order(reached)})
    echelon = Echelon(field, forms.order(range(len(forms.columns))))
    waiting = list(rows)
    while waiting:
        rest = echelon.reduce(polynomial_row(field, waiting.pop(0)))
        if rest:
            rest = echelon.strip(rest)
            echelon.insert(rest)
            waiting.append(forms.rate(field_row(field, rest)))
    return Span(forms, {p: echelon.rows[p] for p in forms.order(echelon.rows)})
