"""The full lift of a reducible system, one variable for each pair (function, state) that may occur.

    x₁' = A₁₁ x₁ + A₁₂(t) x₂,   x₂' = 0,   y = H₀ x₁ + H(t) x₂,   f' = S f:      z = (x₁, f ⊗ x₂)
    x' = A x,   y = H(t) x,   f' = S f:                                          z = f ⊗ x

The variables are single columns (state, mode), independent over the constants as the modes are. So the
combinations c of them that are observable correspond to the forms in the closure of the rows of H, one to
one: the rank of the observability matrix of the full lift is the dimension of that closure, as it is for
every other lift.

References
----------
Morozov & Baklanov 2018, (13), (17).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from obscli.exact.lift_finding import Kronecker, Lift
from obscli.exact.lift_writing import variable_names


if TYPE_CHECKING:
    from collections.abc import Iterable

    from obscli.exact.constant_span import Forms
    from obscli.exact.lift_writing import Writer
    from obscli.exact.mode import Mode


def full_columns(forms: Forms) -> list[int] | None:
    """Return the columns of the full lift in order; None where the moving states do not move by a matrix."""
    if not forms.closes:
        return None
    found = {k for row in forms.H for k in row} | {forms.column(i, forms.modes.one) for i in forms.moving}
    constant = [i for i in range(len(forms.A)) if i not in forms.moving]
    while True:
        reached = [forms.columns[k] for k in forms.reached(found)]
        columns = []
        for group in (forms.moving, constant):
            functions = ordered({mode for state, mode in reached if state in group})
            columns += [forms.column(state, mode) for mode in functions for state in group]
        if found == set(columns):
            return columns
        found = set(columns)


def functions_in(forms: Forms) -> list[Mode]:
    """Return the modes in A and H, closed under differentiation."""
    entries = [e for row in forms.A for e in row.values()]
    found = {mode for entry in entries for mode in entry} | {
        forms.columns[k][1] for row in forms.H for k in row
    }
    waiting = list(found)
    while waiting:
        fresh = {mode for mode, _ in forms.modes.rate(waiting.pop())} - found
        found |= fresh
        waiting += fresh
    return ordered(found)


def ordered(modes: Iterable[Mode]) -> list[Mode]:
    """Return modes in order."""
    return sorted(modes, key=lambda mode: mode.place)


def kronecker(forms: Forms, writer: Writer, rank: int) -> Kronecker | None:
    """Return the full lift, of which the rank is known.

    Parameters
    ----------
    rank : the dimension of the closure of the rows of H
    """
    columns = full_columns(forms)
    if columns is None:
        return None
    places = {column: k for k, column in enumerate(columns)}
    variables = writer.columns(columns)
    A = ({places[k]: c for k, c in forms.column_rate(column).items()} for column in columns)
    H = ({places[k]: c for k, c in row.items()} for row in forms.H)
    lift = Lift(
        variable_names(forms.modes.exact.system, variables), variables, writer.matrix(A), writer.matrix(H)
    )
    return Kronecker(len(columns), rank, lift)
