"""A basis of observable combinations held against the Gramian: what was seen, instant by instant."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias


Agreement: TypeAlias = Literal["verified", "contradicted", "undecided", "not excited"]


@dataclass(frozen=True, slots=True)
class NotVerified:
    """The two sides could not be compared, and why."""

    reason: str


@dataclass(frozen=True, slots=True)
class Point:
    """One instant: r rows, kernel of dimension q, χ and its bound (None: nothing to compare), the gap of q.

    ``conclusive``: the rank is decided and is the whole rank, and every row can be judged, or one leaks;
    ``agrees``: χ is below its bound and r + q = n; ``refutes``: χ is far above it, or r + q is not n.
    """

    t: float
    r: int
    q: int
    chi: float | None
    bound: float | None
    gap: float | None
    conclusive: bool
    agrees: bool
    refutes: bool


@dataclass(frozen=True, slots=True, eq=False)
class CombinationCheck:
    """One combination: its worst χ and the bound there; whether it holds, None where that cannot be told."""

    expression: str
    chi: float | None
    bound: float | None
    holds: bool | None
    correction: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Verification:
    """A basis against the Gramian: the verdict, every instant and combination, the paper's diagnosis.

    ``not excited``: signals are recorded data, and these show less than generic ones would.
    """

    verdict: Agreement
    reason: str
    diagnosis: str
    n: int
    points: tuple[Point, ...]
    combinations: tuple[CombinationCheck, ...]

    @property
    def agree(self) -> int:
        """At how many instants the Gramian agrees."""
        return sum(point.agrees for point in self.points)

    @property
    def worst(self) -> Point | None:
        """The conclusive instant with the largest χ, None where there is nothing to compare."""
        known = [point for point in self.points if point.conclusive and point.chi is not None]
        return max(known, key=lambda point: point.chi or 0.0, default=None)
