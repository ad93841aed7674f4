"""What a transformation of one stage gives: a model, what its states mean, and what was checked of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias

from obscli.core.check import CheckResult
from obscli.exact.finding import Undecided
from obscli.exact.lift_finding import NotReducible, Stationary
from obscli.exact.reduced import StateBack
from obscli.model.acting import InputMatrix
from obscli.model.expression import Expression
from obscli.model.system import Covector, Model, System
from obscli.pipelines.request import Target
from obscli.pipelines.stage_result import stage_title


if TYPE_CHECKING:
    from obscli.numeric.finding import NotComputed
    from obscli.numeric.floquet_finding import Floquet


@dataclass(frozen=True, slots=True, eq=False)
class Transformed:
    """A model in new variables.

    Parameters
    ----------
    system : the model, as its file reads
    text : the file
    forms : what each state of it means, in the states of the model it comes from
    sizes : of the parts: observable and not, or the four of the Kalman decomposition
    by : the matrix the reachable subspace is of, where there are four
    left_out : the states that are free, or dropped
    back : the other states in the new ones and the free ones
    divides_by : what the equations are not defined at the zeros of
    checks : what was checked of the file
    notes : what did not carry over
    is_exact : whether dropping states loses nothing; None where that was not asked for
    moved : dropped states that others move
    """

    system: System
    text: str
    forms: tuple[Covector, ...]
    sizes: tuple[int, ...]
    checks: tuple[CheckResult, ...]
    by: InputMatrix | None = None
    left_out: tuple[str, ...] = ()
    back: Mapping[str, StateBack] = field(default_factory=dict)
    divides_by: tuple[Expression, ...] = ()
    notes: tuple[str, ...] = ()
    is_exact: bool | None = None
    moved: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class StationaryForm:
    """A stationary model with the same outputs.

    Parameters
    ----------
    found : everything stationary about the system; ``system`` is its smallest lift
    system : the model, as its file reads
    text : the file
    checks : what was checked of the file, and whether its combinations are those of the system
    notes : what did not carry over
    """

    found: Stationary
    system: System
    text: str
    checks: tuple[CheckResult, ...]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class NoStationaryForm:
    """A system that algebra finds no stationary form of; ``floquet``: that of a periodic one, in numbers."""

    found: NotReducible
    floquet: Floquet | NotComputed | None = None


@dataclass(frozen=True, slots=True, eq=False)
class NothingLeft:
    """No state is left: nothing of the system is observable."""

    reason: str


#: What comes of a transformation.
Finding: TypeAlias = Transformed | StationaryForm | NoStationaryForm | NothingLeft | Undecided


@dataclass(frozen=True, slots=True, eq=False)
class TransformResult:
    """One stage of a model, and what came of its transformation."""

    model: Model
    system: System
    to: Target
    finding: Finding

    @property
    def title(self) -> str:
        """The name of the model, and of the stage where it has one."""
        return stage_title(self.model, self.system)

    @property
    def failed(self) -> int:
        """How many checks failed."""
        return self._count("fails")

    @property
    def undecided(self) -> int:
        """How many things stayed undecided."""
        return 1 if isinstance(self.finding, Undecided) else self._count("undecided")

    def _count(self, verdict: str) -> int:
        if not isinstance(self.finding, Transformed | StationaryForm):
            return 0
        return sum(check.verdict == verdict for check in self.finding.checks)
