"""Closed spaces of forms as stationary systems, in readable variables.

    D v_k = Σ_l a_kl v_l,   h_i = Σ_l h_il v_l      hence     z' = A z,  y = H z     of  z_k = v_k x

The rows v are those of the reduced echelon form, over (state, mode), denominators cleared: printing scales
each by a constant, and A and H with it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from obscli.exact.errors import UndecidedError
from obscli.exact.field import Element
from obscli.exact.lift_finding import Functions, Lift
from obscli.exact.reduced import written
from obscli.model.expression import add, multiply
from obscli.model.variables import is_state, taken_names


if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from obscli.exact.closure import Span
    from obscli.exact.constant_span import Forms
    from obscli.exact.echelon import PolyRow
    from obscli.exact.exact_system import Row
    from obscli.exact.lift_finding import Rows
    from obscli.exact.mode import Mode
    from obscli.exact.restore import Restorer
    from obscli.model.expression import Expression
    from obscli.model.system import Covector, System


class Writer:
    """Writes forms, spaces of forms and modes of one system."""

    def __init__(self, forms: Forms, restorer: Restorer) -> None:
        self._forms, self._restorer = forms, restorer
        self._exact = forms.modes.exact

    def form(self, row: PolyRow) -> tuple[Covector, Element]:
        """Return a form in the states, and the constant that it is multiplied by."""
        columns = self._forms.order(row)
        restored = self._restorer.row(dict(enumerate(row[k] for k in columns)))
        first = Element(self._forms.field, row[columns[0]], self._forms.field.one_polynomial)
        scale = self._exact.interpreter.read(restored[0]) / first
        return self._covector({k: restored[i] for i, k in enumerate(columns)}), scale

    def _covector(self, row: Mapping[int, Expression]) -> Covector:
        names = self._exact.system.state_names
        terms: dict[int, list[Expression]] = {}
        for k, coefficient in row.items():
            state, mode = self._forms.columns[k]
            terms.setdefault(state, []).append(multiply(coefficient, self._forms.modes.expression(mode)))
        return {names[state]: add(*terms[state]) for state in sorted(terms)}

    def lift(self, span: Span) -> Lift:
        """Return the stationary system of a closed space that has the rows of H.

        Raises
        ------
        UndecidedError : it is not closed (the modular screen was misled: practically impossible)
        """
        forms, field = self._forms, self._forms.field
        places = {p: k for k, p in enumerate(span.rows)}
        variables = [self.form(row) for row in span.rows.values()]
        covectors, scales = [form for form, _ in variables], [scale for _, scale in variables]

        def in_z(form: Row, scale: Element) -> Mapping[int, Expression]:
            found = span.coordinates(form)
            if found is None:
                raise UndecidedError("the variables of a stationary system were found not to close")
            entries = {places[p]: entry * scale / scales[places[p]] for p, entry in found.items()}
            return {k: written(self._restorer, entries[k]) for k in sorted(entries)}

        rates = map(forms.rate, span.basis.values())
        return Lift(
            names=variable_names(self._exact.system, covectors),
            variables=tuple(covectors),
            A=tuple(map(in_z, rates, scales)),
            H=tuple(in_z(row, field.one) for row in forms.H),
        )

    def functions(self, modes: Sequence[Mode]) -> Functions:
        """Return modes, closed under differentiation, and S."""
        places = {mode: k for k, mode in enumerate(modes)}
        rates = (self._forms.modes.rate(mode) for mode in modes)
        S = self.matrix({places[other]: entry for other, entry in rate} for rate in rates)
        return Functions(tuple(map(self._forms.modes.expression, modes)), S)

    def matrix(self, rows: Iterable[Row]) -> Rows:
        """Return rows of constants as expressions."""
        return tuple({k: written(self._restorer, row[k]) for k in sorted(row)} for row in rows)

    def columns(self, columns: Sequence[int]) -> tuple[Covector, ...]:
        """Return single columns as forms: a mode times a state."""
        names, modes = self._exact.system.state_names, self._forms.modes
        pairs = (self._forms.columns[k] for k in columns)
        return tuple({names[state]: modes.expression(mode)} for state, mode in pairs)


def variable_names(system: System, forms: Sequence[Covector]) -> tuple[str, ...]:
    """Return the name of the state for a variable that is one, and z1, z2, … for the others."""
    taken = taken_names(system)
    free = (name for k in range(1, 100_000) if (name := f"z{k}") not in taken)
    return tuple(next(iter(form)) if is_state(form) else next(free) for form in forms)
