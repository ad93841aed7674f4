"""What measures find in one stage."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from obscli.exact.finding import Undecided
from obscli.measures.measure import Found, Measure
from obscli.measures.subject import Subject
from obscli.model.system import Model, System
from obscli.numeric.finding import NotComputed
from obscli.numeric.horizon import Horizon
from obscli.numeric.program import Array
from obscli.pipelines.stage_result import stage_title


@dataclass(frozen=True, slots=True, eq=False)
class Taken:
    """All measures at one instant, by key."""

    subject: Subject
    found: Mapping[str, Found | NotComputed]

    def value(self, key: str, target: str) -> float | None:
        """Return what a measure finds for a target; None where it finds nothing."""
        found = self.found.get(key)
        if not isinstance(found, Found) or not found.targets:
            return None
        names = [one.name for one in self.subject.targets]
        return found.targets[names.index(target)] if target in names else None


@dataclass(frozen=True, slots=True)
class Limit:
    """A value held against what the user asks: at most, or at least.

    ``key``: of the measure; ``target``: state or quantity; ``met``: None where there is no value.
    """

    key: str
    target: str
    limit: float
    value: float | None
    met: bool | None


@dataclass(frozen=True, slots=True)
class Reordering:
    """A measure by which the states rank differently in other units."""

    key: str
    given: tuple[str, ...]
    other: tuple[str, ...]
    units: str


@dataclass(frozen=True, slots=True, eq=False)
class Curves:
    """Measures from the noise against time, for the figures: by key, shape (k, targets)."""

    t: Array
    values: Mapping[str, Array]


@dataclass(frozen=True, slots=True, eq=False)
class MeasuresResult:
    """The measures of one stage.

    Parameters
    ----------
    measures : those taken, in order
    taken : at every instant asked for; or why nothing is measured
    units, scaling : of the states, and where they come from
    limits : requirements and thresholds
    reordered : where the ranking of the states depends on their units
    curves : None: not asked for, or no noise
    assumed_step : the time between samples, where the file does not say and one had to be taken
    sampled : functions left open, which follow a sample motion
    """

    model: Model
    system: System
    measures: tuple[Measure, ...]
    taken: tuple[Taken, ...] | Undecided | NotComputed
    scaling: str
    units: Mapping[str, float]
    horizon: Horizon | None = None
    limits: tuple[Limit, ...] = ()
    reordered: tuple[Reordering, ...] = ()
    curves: Curves | None = None
    assumed_step: float | None = None
    sampled: tuple[str, ...] = ()

    @property
    def title(self) -> str:
        """The name of the model, and of the stage where it has one."""
        return stage_title(self.model, self.system)

    @property
    def failed(self) -> int:
        """How many requirements and thresholds are not met."""
        return sum(one.met is False for one in self.limits)

    @property
    def undecided(self) -> int:
        """Whether nothing could be measured, and how many limits could not be judged."""
        return (not isinstance(self.taken, tuple)) + sum(one.met is None for one in self.limits)
