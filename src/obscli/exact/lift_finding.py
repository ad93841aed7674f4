"""What is found of a reducible system: stationary systems in new variables, or what stands in the way.

    z = V(t) x,   z' = A_z z,   y = H_z z     with constant A_z, H_z:     V' + V A = A_z V,   H = H_z V

Morozov & Baklanov 2018, section 5 (reducible systems), (13)–(22).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

from obscli.model.expression import Expression
from obscli.model.system import Covector, System


#: A matrix of expressions by sparse rows.
Rows: TypeAlias = "tuple[Mapping[int, Expression], ...]"


@dataclass(frozen=True, slots=True, eq=False)
class Functions:
    """f(t) with f' = S f, S constant: t^j exp(σ t) cos(ν t), t^j exp(σ t) sin(ν t)."""

    f: tuple[Expression, ...]
    S: Rows


@dataclass(frozen=True, slots=True, eq=False)
class Lift:
    """A stationary system z' = A z, y = H z that the outputs of a system satisfy.

    Parameters
    ----------
    names : of the variables z, no two alike and none a name of the file but that of a state that it is
    variables : z as linear forms in the states, coefficients may depend on time
    A, H : constant, by sparse rows
    """

    names: tuple[str, ...]
    variables: tuple[Covector, ...]
    A: Rows
    H: Rows

    @property
    def n(self) -> int:
        """The number of variables."""
        return len(self.variables)


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """ζ_1, ζ_2, … from one output: ζ_1 is it, ζ_k' a constant times ζ_(k+1), and what was seen before.

    ``output``: its name; ``forms``: ζ_k in the states, up to constant factors; none where the outputs before
    it show everything that it shows.
    """

    output: str
    forms: tuple[Covector, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Stationary:
    """Everything stationary about a reducible system.

    Parameters
    ----------
    functions : of time in A(t), H(t), closed under differentiation
    full : the Kronecker lift, (13) or (17); None: the moving states do not move by a constant matrix among
        themselves, so that there is none
    smallest : the moving states, and what acts on them or is seen of the others, closed under d/dt
    observable : the outputs alone, closed: as many variables as it takes
    same_order : as many variables as states, and a change of variables x = T(t) z; None: none found
    rank : of the observability matrix of the smallest lift, over the constants
    chains : what each output gives, one derivative after the other, those outputs first that give least by
        themselves; none where the coefficients grow too large
    combinations : observable combinations of the states, from the stationary system
    agrees : whether they span the same as the observability matrix of the system itself, exactly
    left_out : moving states that are not in the smallest lift, as what acts on them does not close
    """

    system: System
    functions: Functions
    full: Kronecker | None
    smallest: Lift
    observable: Lift
    same_order: Lift | None
    rank: int
    chains: tuple[Chain, ...]
    combinations: tuple[Covector, ...]
    agrees: bool
    left_out: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Kronecker:
    """The full lift z = (x₁, f ⊗ x₂): x₁ the moving states, x₂ the others (all, where only H varies).

    ``variables``: z as linear forms in the states; ``rank``: of its observability matrix over the constants.
    """

    n: int
    rank: int
    lift: Lift


@dataclass(frozen=True, slots=True, eq=False)
class Obstacle:
    """What stands in the way of a stationary system.

    ``entry``: the coefficient, ``A[psi1, b_g1]``; ``place``: in the file, where it is known; ``reason``: why.
    """

    entry: str
    place: str
    reason: str


@dataclass(frozen=True, slots=True, eq=False)
class NotReducible:
    """A system that is not reducible in this way, and why."""

    system: System
    obstacles: tuple[Obstacle, ...]
