"""What was found about one stage."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from obscli.checks.certified_rank import CertifiedRank
from obscli.checks.detectability import Detectability
from obscli.core.check import CheckResult
from obscli.core.verification import NotVerified, Verification
from obscli.exact.finding import Analysis, Undecided
from obscli.exact.lift_finding import Stationary
from obscli.model.system import Model, System
from obscli.numeric.finding import CrossCheck, EchelonFinding, NotComputed, NumericFinding
from obscli.pipelines.freezing import Frozen
from obscli.pipelines.request import Part


#: What stands for the name of a stage where the result is about the segments.
SEGMENTS: Final = "segments"


@dataclass(frozen=True, slots=True, eq=False)
class StageResult:
    """One stage of a model and what each pipeline found about it; None: the pipeline was not asked.

    ``shown``: the one part the user asked to see, None: all; ``basis``: the numerical basis in time;
    ``detectability``: whether what is unobservable dies out, ``detectability_there``: at the file's values,
    where more is unobservable; ``cross_check``: the Riccati equation from two priors; ``frozen``: the instant
    at which ``system`` is frozen, and the rank in truth; ``certified``: the rank of the Gramian, proved;
    ``stationary``: of a system that varies, time-invariant ones with the same outputs, where there are any.
    """

    model: Model
    system: System
    finding: Analysis | Undecided | None
    numeric: NumericFinding | NotComputed | None = None
    verification: Verification | NotVerified | None = None
    basis: EchelonFinding | None = None
    shown: Part | None = None
    detectability: Detectability | None = None
    detectability_there: Detectability | None = None
    cross_check: CrossCheck | NotComputed | None = None
    frozen: Frozen | None = None
    certified: CertifiedRank | None = None
    stationary: Stationary | None = None

    @property
    def title(self) -> str:
        """The name of the model, and of the stage where it has one."""
        return stage_title(self.model, self.system)

    @property
    def is_undecided(self) -> bool:
        """Whether anything that was asked about the stage's rank stayed undecided."""
        return self._is_shown_undecided or (self.certified is not None and self.certified.is_undecided)

    @property
    def _is_shown_undecided(self) -> bool:
        match self.shown:
            case "analytic":
                return not self.is_proved
            case "structure":
                return self.detectability is None or self.detectability.verdict == "undecided"
            case "numeric":
                return not isinstance(self.numeric, NumericFinding) or self.numeric.rank is None
            case "verify":
                return not self._is_compared
        return not (self.is_proved and self._is_compared)

    @property
    def is_proved(self) -> bool:
        """Whether the exact side decided everything."""
        return isinstance(self.finding, Analysis) and not self.finding.undecided

    @property
    def _is_compared(self) -> bool:
        return isinstance(self.verification, Verification) and self.verification.verdict != "undecided"

    @property
    def is_contradicted(self) -> bool:
        """Whether the exact side is contradicted: by the Gramian, or by a stationary system."""
        if self.stationary is not None and not self.stationary.agrees:
            return True
        return isinstance(self.verification, Verification) and self.verification.verdict == "contradicted"


@dataclass(frozen=True, slots=True, eq=False)
class StageChecks:
    """One stage of a model and the checks made on it; ``verification``: its analysis against the Gramian."""

    model: Model
    system: System
    checks: tuple[CheckResult, ...]
    verification: Verification | NotVerified | None = None

    @property
    def title(self) -> str:
        """The name of the model, and of the stage where it has one."""
        return stage_title(self.model, self.system)


def systems_of(model: Model, system: System) -> tuple[System, ...]:
    """Return the systems that a result is about: one, or those of the segments one after the other."""
    if system.stage == SEGMENTS and model.segments is not None:
        return tuple(one.system for one in model.segments.parts)
    return (system,)


def stage_title(model: Model, system: System) -> str:
    """Return the name of the model, and of the stage where it has one."""
    return model.name if system.stage is None else f"{model.name} · {system.stage}"
