"""What the exact pipeline finds about one system: frozen values, no text but expressions.

Covectors (rows) are observable combinations s = Σ ξ_i x_i; directions (columns) span the unobservable
subspace. All coefficients are expressions in the grammar of the model file.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias

from obscli.exact.relations_finding import Relations
from obscli.exact.structure_finding import Structure
from obscli.model.expression import Expression
from obscli.model.system import Covector, System


#: observable: the state itself is known; coupled: it enters a combination; unobservable: it enters none.
StateVerdict: TypeAlias = Literal["observable", "coupled", "unobservable"]

#: The verdict of a quantity, whose own coefficients may leave it open.
LinearFormVerdict: TypeAlias = StateVerdict | Literal["undecided"]


@dataclass(frozen=True, slots=True, eq=False)
class Combination:
    """One observable combination of a basis, and the row of L that first yields it.

    ``constant`` says that the combination does not change in time along solutions: ξ' + ξA = 0.
    ``output``, ``order``: adding this row of L (output's ``order``-th derivative, rows taken by order,
    then by output) to the ones before it brings the combination into the span.
    """

    coefficients: Covector
    constant: bool
    output: str
    order: int


@dataclass(frozen=True, slots=True, eq=False)
class LowerBound:
    """rank L ≥ r: the minor of L with these rows and columns at a rational point excludes zero.

    ``point``: value of time, parameters and jets of functions as exact text; ``rows``: (output, order);
    ``columns``: states; ``midpoint`` ± ``radius``: the ball of the determinant at ``precision`` bits.
    """

    point: Mapping[str, str]
    rows: tuple[tuple[str, int], ...]
    columns: tuple[str, ...]
    midpoint: str
    radius: str
    precision: int


@dataclass(frozen=True, slots=True, eq=False)
class UpperBound:
    """rank L ≤ r: H N = 0 and N' − A N = N X exactly, N of full column rank n − r.

    ``kernel``: columns of N; ``multiplier``: X by columns. ``delay``: a direction w with L_k w = 0 for all
    k below the saturation order and not at it (so the order is not smaller); None where the order is 0, or
    where there are fewer rows below it than the rank.
    """

    kernel: tuple[Covector, ...]
    multiplier: tuple[tuple[Expression, ...], ...]
    delay: Covector | None


@dataclass(frozen=True, slots=True, eq=False)
class Certificate:
    """The proof of one generic rank, checkable without the elimination that found it."""

    model: str
    rank: int
    order: int
    lower: LowerBound
    upper: UpperBound
    assumes: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class CriticalValue:
    """A hypersurface of parameter space, or an identity among functions, and what it does to the rank.

    ``condition``: readable text such as ``alpha_w = alpha_omega`` or ``f_E = f_N = 0``.
    ``kind``: confirmed (rank is lower there, proved), excluded (proved, but outside ``assume``),
    undefined (A or H do not exist there), undecided (candidate that could not be decided; reason says why),
    candidate (nobody has asked yet).
    ``zero``: an expression that vanishes exactly there, where there is one; ``values``: the values of a
    parameter that it stands for, one mapping each (phi = pi/2 and phi = -pi/2 for cos(phi) = 0).
    """

    condition: str
    kind: Literal["confirmed", "excluded", "undefined", "undecided", "candidate"]
    rank: int | None
    lost: tuple[Covector, ...]
    reason: str = ""
    functions: bool = False
    zero: Expression | None = None
    values: tuple[Mapping[str, Expression], ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class CriticalSearch:
    """All critical values found, whether the search is complete in codimension one, what was not searched."""

    values: tuple[CriticalValue, ...]
    complete: bool
    not_searched: tuple[str, ...]
    instants: tuple[str, ...]


#: What a distance is relative to: the value itself, another parameter of its unit, the fastest other rate.
Measure: TypeAlias = Literal["value", "unit", "rate"]


@dataclass(frozen=True, slots=True, eq=False)
class NearMiss:
    """A condition that the file's values miss by little, and the rank where it holds."""

    condition: str
    rank: int
    distance: float
    measure: Measure


@dataclass(frozen=True, slots=True, eq=False)
class AtValues:
    """The exact rank at the file's parameter values; ``because``: conditions that explain a difference.

    ``nearly``: conditions almost met at which the rank is lower still, the nearest first.
    """

    rank: int | None
    because: tuple[str, ...]
    reason: str = ""
    certificate: Certificate | None = None
    nearly: tuple[NearMiss, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class QuantityVerdict:
    """Verdict of one quantity, with its own coefficients and the group of states it is coupled with."""

    name: str
    coefficients: Covector
    verdict: LinearFormVerdict
    group: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Neglect:
    """What an exact substitution (``--fix omega_ie=0``) changes, against the system as it stands."""

    substitution: str
    rank_before: int
    rank_after: int
    lost: tuple[Covector, ...]
    gained: tuple[Covector, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Analysis:
    """The analytic result for one system; ``undecided`` is empty where everything is proved.

    ``groups``: connected components of the graph states × combinations with more than one state.
    ``varying``: what varies in time, as readable text (``sin, cos of omega*t``; functions by name).
    ``structure``: how the unobservable subspace moves, ``relations``: what the outputs are made of; None: not
    asked for.
    ``free``: the free state of each unobservable direction: measured, each would remove its direction.
    ``notes``: remarks that belong into the report (relations not stated, upper bound only, …).
    """

    system: System
    rank: int
    order: int
    combinations: tuple[Combination, ...]
    unobservable: tuple[Covector, ...]
    states: Mapping[str, StateVerdict]
    groups: tuple[tuple[str, ...], ...]
    quantities: tuple[QuantityVerdict, ...]
    certificate: Certificate | None
    at_values: AtValues
    frozen_rank: int | None
    critical: CriticalSearch | None
    varying: tuple[str, ...]
    undecided: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    advice: tuple[str, ...] = ()
    free: tuple[str, ...] = ()
    neglect: tuple[Neglect, ...] = ()
    structure: Structure | None = None
    relations: Relations | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Undecided:
    """A system whose exact analysis could not be carried out, and why (a place in the file in the text)."""

    system: System
    reason: str
