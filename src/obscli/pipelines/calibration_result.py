"""What was found about one experiment."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from obscli.core.verification import NotVerified, Verification
from obscli.exact.finding import Analysis, StateVerdict
from obscli.experiment.exact_side import Exact
from obscli.experiment.stacked import RunRows
from obscli.model.system import Experiment, Model, Run
from obscli.numeric.finding import NotComputed, NumericFinding
from obscli.pipelines.request import CalibrationPart


if TYPE_CHECKING:
    from obscli.experiment.accuracy import Accuracy


@dataclass(frozen=True, slots=True, eq=False)
class RunResult:
    """One run: its rows M_i, its Gramian, and what that says of its analysis; None: not asked for."""

    run: Run
    rows: RunRows
    numeric: NumericFinding | NotComputed | None = None
    verification: Verification | NotVerified | None = None

    def verdict(self, state: str) -> StateVerdict | None:
        """Return what this run alone says of a shared state; None where it is undecided."""
        return self.rows.verdict(state)

    @property
    def lasts(self) -> tuple[float, float] | None:
        """Start and stop, where the Gramian was found."""
        found = self.numeric
        return (found.start, found.points[-1].t) if isinstance(found, NumericFinding) else None


@dataclass(frozen=True, slots=True, eq=False)
class CalibrationResult:
    """One experiment of a model and what was found about it.

    Parameters
    ----------
    model, experiment : what it is about; ``is_default``: the file has none, every stage is a run
    exact : what algebra says
    runs : every run with what both sides say of it
    verification : the joint combinations against the joint Gramian
    together : the joint Gramian at fractions of the runs
    after : its rank after each run
    accuracy : how well; ``no_accuracy`` says why there is none
    shown : the part the user asked for, None: all
    """

    model: Model
    experiment: Experiment
    is_default: bool
    exact: Exact
    runs: tuple[RunResult, ...]
    verification: Verification | NotVerified | None = None
    together: NumericFinding | None = None
    after: tuple[int, ...] | None = None
    accuracy: Accuracy | None = None
    no_accuracy: str = ""
    shown: CalibrationPart | None = None

    @property
    def title(self) -> str:
        """The name of the model, and of the experiment where it has one."""
        name = self.experiment.name
        return f"{self.model.name} · {name}" if name else f"{self.model.name} · experiment"

    @property
    def verifications(self) -> tuple[Verification | NotVerified, ...]:
        """All comparisons of the two sides that were made."""
        found = (self.verification, *(one.verification for one in self.runs))
        return tuple(one for one in found if one is not None)

    @property
    def failed(self) -> int:
        """How many comparisons contradict, and requirements are not met."""
        contradicted = sum(
            isinstance(one, Verification) and one.verdict == "contradicted" for one in self.verifications
        )
        return (
            contradicted + sum(not one.is_met for one in self.accuracy.required)
            if self.accuracy
            else contradicted
        )

    @property
    def undecided(self) -> int:
        """How many things stayed undecided."""
        open_ = sum(isinstance(one, NotVerified) or one.verdict == "undecided" for one in self.verifications)
        exact = (not isinstance(self.exact.stack.finding, Analysis)) + (self.exact.at_file.rank is None)
        return open_ + exact + self.asks_in_vain

    @property
    def asks_in_vain(self) -> bool:
        """Whether accuracy is asked for, but cannot be told."""
        return bool(self.model.require) and self.accuracy is None and self.shown is None
