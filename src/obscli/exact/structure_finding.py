"""What is found about the structure of a system: how the unobservable subspace moves by itself.

On the unobservable subspace x = N z the system moves as z' = A22 z, whatever the outputs are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from obscli.model.system import Covector


#: How a mode goes on by itself; depends: on parameters; undecided: on constants whose sign was not found.
ModeKind: TypeAlias = Literal["decaying", "neutral", "growing", "depends", "undecided"]

#: Whether all errors that no output shows die out: at all times, or as far as the scope says.
StructureVerdict: TypeAlias = Literal["observable", "detectable", "not detectable", "depends", "undecided"]


@dataclass(frozen=True, slots=True, eq=False)
class Mode:
    """One mode of z' = A22 z: a direction that stays by itself, and how it moves.

    ``eigenvalue``: as readable text (a pair where it is complex, ``±i*omega``); ``values``: the eigenvalues
    at the file's values (one, or a pair, or the roots of a polynomial), empty where a value is missing;
    ``kind_there``: the kind at these values.
    ``condition``: where the kind depends on parameters, what makes it decay (empty: nothing does).
    ``chained``: the direction moves into the others of the same eigenvalue, so it grows by a power of time
    more than they do. ``discrete``: z(k+1) = A22 z(k), and a mode moves as s^k.
    """

    eigenvalue: str
    kind: ModeKind
    direction: Covector
    values: tuple[complex, ...] = ()
    kind_there: ModeKind = "undecided"
    condition: str = ""
    chained: bool = False
    discrete: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class OnCondition:
    """The structure where a critical condition holds: more is unobservable there."""

    condition: str
    structure: Structure


@dataclass(frozen=True, slots=True, eq=False)
class Structure:
    """How the unobservable subspace moves.

    Parameters
    ----------
    dimension : of the unobservable subspace
    verdict : for generic parameter values; depends: on what ``condition`` says
    condition : ``detectable iff …`` without these words; empty where nothing depends on parameters
    modes : of A22 where it is constant, each direction of a basis; else empty
    reason : why the verdict is undecided, or what it rests on
    period : period of A22 and N, as a number of seconds, where the system has one and needs it
    at_values : the structure at the file's values, where it may differ from this one
    critical : the structure on critical conditions, where something is lost
    kalman : dimensions of the four parts of the Kalman decomposition, None without B and G
    inputs : the matrix the reachable subspace is of
    directions : a basis of the unobservable subspace
    """

    dimension: int
    verdict: StructureVerdict
    condition: str = ""
    modes: tuple[Mode, ...] = ()
    reason: str = ""
    period: float | None = None
    at_values: Structure | None = None
    critical: tuple[OnCondition, ...] = ()
    kalman: tuple[int, int, int, int] | None = None
    inputs: Literal["B", "G"] | None = None
    directions: tuple[Covector, ...] = ()
