"""What was found about one target in one stage."""

from __future__ import annotations

from dataclasses import dataclass

from obscli.exact.finding import Undecided
from obscli.exact.why import Explanation
from obscli.model.system import Model, Quantity, System
from obscli.numeric.finding import Knowledge, NotComputed
from obscli.pipelines.stage_result import stage_title


@dataclass(frozen=True, slots=True, eq=False)
class WhyResult:
    """One target in one stage: why it is observable or not; with noise in the file, how well it is known."""

    model: Model
    system: System
    target: Quantity
    finding: Explanation | Undecided
    known: Knowledge | NotComputed | None

    @property
    def title(self) -> str:
        """The name of the model, and of the stage where it has one."""
        return stage_title(self.model, self.system)

    @property
    def is_undecided(self) -> bool:
        """Whether the verdict for generic values stayed undecided."""
        return isinstance(self.finding, Undecided) or self.finding.verdict == "undecided"
