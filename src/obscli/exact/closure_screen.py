"""Closed spaces of forms at a random point modulo a prime: their dimensions, and ranks over the field.

Forms that are independent there are independent. That the space of some forms and all their derivatives has
no more dimensions is proved afterwards, by identities; that it has more than a given number is certain.
"""

from __future__ import annotations

import random
from typing import TYPE_CHECKING, Final, TypeAlias

from obscli.exact.errors import UndecidedError
from obscli.exact.series import PRIME, BadPointError, SeriesPoint


if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from obscli.exact.constant_span import Forms
    from obscli.exact.exact_system import Row
    from obscli.exact.field import Element
    from obscli.exact.mode import Mode


_SEED: Final = 20261126
_ENDLESS: Final = 10**6

#: A form modulo the prime.
Values: TypeAlias = "dict[int, int]"


class Screen:
    """Forms at a random point of the constants modulo a prime, and of time too where that is asked for."""

    def __init__(self, forms: Forms) -> None:
        self._forms = forms
        self._point = SeriesPoint(forms.field, 1, _SEED)
        self._rates: dict[int, Values] = {}
        source = random.Random(_SEED)  # noqa: S311  (a random point, no secret)
        self._time = source.randrange(2, PRIME)
        self._half_turns = [_circle(source.randrange(2, PRIME)) for _ in forms.modes.angles]
        self._growth = [source.randrange(2, PRIME) for _ in forms.modes.exponentials]
        self._modes: dict[Mode, int] = {}

    def values(self, form: Mapping[int, Element]) -> Values:
        """Return the coefficients of a form at the point."""
        try:
            found = {k: int(self._point.value(entry)[0]) for k, entry in form.items()}
        except BadPointError:
            raise UndecidedError("no point was found at which the coefficients exist") from None
        return {k: value for k, value in found.items() if value}

    def closure(
        self,
        rows: Iterable[Row],
        known: Mapping[int, Values] | None = None,
        *,
        dimensions: int = _ENDLESS,
        columns: int = _ENDLESS,
    ) -> dict[int, Values] | None:
        """Return an echelon form of the closure.

        Parameters
        ----------
        known : that of a closed space, which the rows are added to
        dimensions, columns : None is returned where it has more dimensions, or rows in more columns
        """
        echelon, met = dict(known or {}), set[int]()
        waiting = [self.values(row) for row in rows]
        while waiting:
            fresh = insert(echelon, waiting.pop(0))
            if fresh:
                met.update(fresh)
                if len(echelon) > dimensions or len(met) > columns:
                    return None
                waiting.append(self._rate(fresh))
        return echelon

    def closes(self, rows: Iterable[Row], columns: int) -> bool:
        """Whether forms lie in a closed space, in so many columns at most."""
        return self.closure(rows, columns=columns) is not None

    def finite(self, rows: Iterable[Row]) -> dict[int, Values]:
        """Return an echelon form of a closure that is known to be finite."""
        return self.closure(rows) or {}

    def _rate(self, row: Values) -> Values:
        total: Values = {}
        for k, value in row.items():
            if k not in self._rates:
                self._rates[k] = self.values(self._forms.column_rate(k))
            for j, entry in self._rates[k].items():
                total[j] = (total.get(j, 0) + value * entry) % PRIME
        return {j: value for j, value in total.items() if value}

    def rank_over_the_field(self, rows: Iterable[Values]) -> int:
        """Return the rank at a random instant of forms by states: the rank over the field is not below it."""
        echelon: dict[int, Values] = {}
        for row in rows:
            at_instant: Values = {}
            for k, value in row.items():
                state, mode = self._forms.columns[k]
                at_instant[state] = (at_instant.get(state, 0) + value * self._mode(mode)) % PRIME
            insert(echelon, {j: value for j, value in at_instant.items() if value})
        return len(echelon)

    def _mode(self, mode: Mode) -> int:
        if mode not in self._modes:
            self._modes[mode] = self._mode_value(mode)
        return self._modes[mode]

    def _mode_value(self, mode: Mode) -> int:
        result = pow(self._time, mode.power, PRIME)
        for base, exponent in zip(self._growth, mode.exponents, strict=True):
            result = result * pow(base, exponent, PRIME) % PRIME
        cosine, sine = 1, 0
        for (c, s), turns in zip(self._half_turns, mode.turns, strict=True):
            for _ in range(abs(turns)):
                signed = s if turns > 0 else -s
                cosine, sine = (cosine * c - sine * signed) % PRIME, (cosine * signed + sine * c) % PRIME
        return result * (sine if mode.sine else cosine) % PRIME


def insert(echelon: dict[int, Values], row: Values) -> Values:
    """Reduce a row by an echelon form modulo the prime, insert what remains and return it."""
    row = dict(row)
    while pivots := [p for p in row if p in echelon]:
        for p in pivots:
            if not (factor := row.get(p, 0)):
                continue
            for j, value in echelon[p].items():
                rest = (row.get(j, 0) - factor * value) % PRIME
                if rest:
                    row[j] = rest
                else:
                    row.pop(j, None)
    if row:
        pivot = min(row)
        inverse = pow(row[pivot], -1, PRIME)
        row = {j: value * inverse % PRIME for j, value in row.items()}
        echelon[pivot] = row
    return row


def _circle(tangent: int) -> tuple[int, int]:
    """Return a point of the unit circle by the tangent of half its angle."""
    below = pow(1 + tangent * tangent, -1, PRIME)
    return (1 - tangent * tangent) * below % PRIME, 2 * tangent * below % PRIME
