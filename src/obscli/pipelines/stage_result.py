"""What was found about one stage."""

from __future__ import annotations

from dataclasses import dataclass

from obscli.core.check import CheckResult
from obscli.exact.finding import Analysis, Undecided
from obscli.model.system import Model, System


@dataclass(frozen=True, slots=True, eq=False)
class StageResult:
    """One stage of a model and the finding about it."""

    model: Model
    system: System
    finding: Analysis | Undecided

    @property
    def title(self) -> str:
        """The name of the model, and of the stage where it has one."""
        return stage_title(self.model, self.system)

    @property
    def is_undecided(self) -> bool:
        """Whether anything about the stage's rank stayed undecided."""
        return isinstance(self.finding, Undecided) or bool(self.finding.undecided)


@dataclass(frozen=True, slots=True, eq=False)
class StageChecks:
    """One stage of a model and the checks made on it."""

    model: Model
    system: System
    checks: tuple[CheckResult, ...]

    @property
    def title(self) -> str:
        """The name of the model, and of the stage where it has one."""
        return stage_title(self.model, self.system)


def stage_title(model: Model, system: System) -> str:
    """Return the name of the model, and of the stage where it has one."""
    return model.name if system.stage is None else f"{model.name} · {system.stage}"
