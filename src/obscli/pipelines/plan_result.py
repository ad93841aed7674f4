"""What was found about a plan."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from obscli.core.verification import NotVerified, Verification
from obscli.experiment.stacked import Stack
from obscli.model.system import Experiment, Model


if TYPE_CHECKING:
    from obscli.experiment.accuracy import Accuracy
    from obscli.experiment.planning import Plan


@dataclass(frozen=True, slots=True, eq=False)
class PlanResult:
    """The plan for the experiment of one model.

    Parameters
    ----------
    model, experiment : what it is about; ``is_default``: the file has no experiment, every stage is a run
    plan : what was chosen, and from what
    chosen : what the recommended runs determine, proved; ``rank_at_values``: at the file's values
    verification : that against the Gramians
    accuracy : after the recommended runs, each as long as it has to be
    """

    model: Model
    experiment: Experiment
    plan: Plan
    is_default: bool = False
    chosen: Stack | None = None
    rank_at_values: int | None = None
    verification: Verification | NotVerified | None = None
    accuracy: Accuracy | None = None

    @property
    def title(self) -> str:
        """The name of the model, and of the experiment where it has one."""
        chosen_from_runs = self.experiment.plan is None or self.experiment.plan.candidates is None
        name = self.experiment.name if chosen_from_runs else ""
        return f"{self.model.name} · {name} · plan" if name else f"{self.model.name} · plan"

    @property
    def failed(self) -> bool:
        """Whether the Gramians contradict, or what is required is not met."""
        contradicted = (
            isinstance(self.verification, Verification) and self.verification.verdict == "contradicted"
        )
        return contradicted or bool(self.accuracy and any(not one.is_met for one in self.accuracy.required))

    @property
    def undecided(self) -> bool:
        """Whether the plan could not be held against the Gramians, or against what is required."""
        found = self.verification
        vain = bool(self.model.require) and self.accuracy is None
        return vain or not isinstance(found, Verification) or found.verdict == "undecided"
