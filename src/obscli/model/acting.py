"""What acts on the states of a system: its inputs, or where there are none its disturbances."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from obscli.model.system import Matrix, System


#: Which matrix says what moves the state: the inputs, or where there are none the disturbances.
InputMatrix: TypeAlias = Literal["B", "G"]


@dataclass(frozen=True, slots=True, eq=False)
class Inputs:
    """The matrix (n, p) that the reachable subspace is of, and the names of its columns."""

    by: InputMatrix
    matrix: Matrix
    names: tuple[str, ...]


def inputs_of(system: System) -> Inputs | None:
    """Return B where the system has inputs, else G, None where it has neither."""
    if system.B is not None and system.B.columns:
        return Inputs("B", system.B, system.inputs)
    if system.G is not None and system.G.columns:
        return Inputs("G", system.G, system.disturbances)
    return None
