"""One thing asserted and what came of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, NoReturn, TypeAlias

from obscli.core.place import Place
from obscli.core.verification import Verification


Verdict: TypeAlias = Literal["holds", "fails", "undecided"]


@dataclass(frozen=True, slots=True)
class Indicator:
    """What the Gramian says of a claim: at how many of the instants that can tell it agrees.

    ``chi`` is the worst leak where there is one, ``bound`` what rounding may account for at that instant.
    """

    agree: int
    of: int
    chi: float | None = None
    bound: float | None = None


@dataclass(frozen=True, slots=True)
class Change:
    """A change of a claimed combination, and the observable combination it gives, as text.

    ``of``: the combination as claimed; ``change``: what to add to it; ``words``: the same in words.
    """

    of: str
    change: str
    corrected: str
    words: str


@dataclass(frozen=True, slots=True, eq=False)
class Trajectories:
    """Two trajectories with the same outputs: their difference by state at some instants.

    ``claim``: by how much the claimed combination differs between them; ``output``: the largest difference of
    the outputs, relative to what the differences of single states would make.
    """

    instants: tuple[float, ...]
    difference: Mapping[str, tuple[float, ...]]
    claim: tuple[float, ...]
    output: float


@dataclass(frozen=True, slots=True, eq=False)
class Counterexample:
    """An unobservable direction along which a claimed combination changes.

    ``direction``: state → expression; ``claim``: by how much the combination changes; ``is_trajectory``:
    whether the direction is a solution of x' = A x as it stands.
    """

    direction: Mapping[str, str]
    claim: str
    is_trajectory: bool
    trajectories: Trajectories | None = None


@dataclass(frozen=True, slots=True, eq=False)
class CheckResult:
    """The verdict on one claim, with its grounds; no truth value, since there are three of them.

    ``claim``: what is asserted, in words; ``reason``: why the verdict stands; ``place``: where it is said.
    ``gramian``: the numerical witness; ``verification``: a claimed basis against it, instant by instant;
    ``corrections``: the smallest changes that make a false combination
    observable; ``transformation``: T with claimed basis = T · proved basis, where it is another form of it.
    """

    claim: str
    verdict: Verdict
    reason: str
    place: Place | None = None
    gramian: Indicator | None = None
    corrections: tuple[Change, ...] = ()
    counterexample: Counterexample | None = None
    transformation: tuple[tuple[str, ...], ...] = ()
    verification: Verification | None = None

    def __bool__(self) -> NoReturn:
        raise TypeError("a CheckResult holds, fails or is undecided: compare its verdict")
