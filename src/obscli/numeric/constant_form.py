"""A stationary system with the outputs of a system that is not: what the numerical side needs of it.

    z = V(t) x,   z' = A_z z,   y = H_z z     with constant A_z, H_z

The numerical side does not find it; it takes it as it takes A(t) and H(t), and evaluates it by itself.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Protocol

from obscli.model.expression import Expression
from obscli.model.system import Covector, Matrix, State, System


class ConstantForm(Protocol):
    """Variables z as linear forms in the states, and constant A_z, H_z by sparse rows."""

    @property
    def variables(self) -> tuple[Covector, ...]:
        """The rows of V(t)."""

    @property
    def A(self) -> tuple[Mapping[int, Expression], ...]:
        """The rows of A_z."""

    @property
    def H(self) -> tuple[Mapping[int, Expression], ...]:
        """The rows of H_z."""


def stationary_system(system: System, form: ConstantForm) -> System:
    """Return z' = A_z z, y = H_z z as a system of its own, with the parameters and outputs of ``system``."""
    place = system.states[0].place
    return replace(
        system,
        states=tuple(State(f"z{k + 1}", place) for k in range(len(form.variables))),
        functions=(),
        invariants=(),
        A=_matrix(form.A, len(form.variables)),
        H=_matrix(form.H, len(form.variables)),
        B=None,
        G=None,
        quantities=(),
        claims=(),
        noise=None,
        prior={},
        scope=None,
    )


def _matrix(rows: tuple[Mapping[int, Expression], ...], columns: int) -> Matrix:
    return Matrix(
        len(rows), columns, {(i, j): entry for i, row in enumerate(rows) for j, entry in row.items()}
    )
