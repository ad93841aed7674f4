"""What a simulation of the Kalman filter finds in one stage."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from obscli.exact.finding import LinearFormVerdict
from obscli.model.system import Covector, Model, System
from obscli.numeric.finding import NotComputed
from obscli.pipelines.stage_result import stage_title


if TYPE_CHECKING:
    from obscli.numeric.feedback import Feedback
    from obscli.numeric.simulation_finding import (
        Followed,
        History,
        MeanResponse,
        MismatchHistory,
        MonteCarlo,
        TimeToObservability,
    )


@dataclass(frozen=True, slots=True, eq=False)
class FollowedForm:
    """A linear form in the states whose deviation is followed.

    ``verdict``: what the outputs say of it at the file's values; None: not known.
    """

    name: str
    kind: Followed
    unit: str
    coefficients: Covector
    verdict: LinearFormVerdict | None


@dataclass(frozen=True, slots=True)
class Sampling:
    """When one output is sampled.

    ``every``: the usual time between samples, None where there are less than two; ``outages``: where there is
    none for longer, between the samples around it or an end of the interval; ``longest``: as ``every``, of
    that segment in which samples are rarest.
    """

    output: str
    samples: int
    every: float | None
    outages: tuple[tuple[float, float], ...]
    longest: float | None = None


@dataclass(frozen=True, slots=True)
class Demand:
    """A standard deviation asked for, and what there is at the end."""

    name: str
    limit: float
    after: float

    @property
    def is_met(self) -> bool:
        """Whether the deviation is at most what is asked for."""
        return self.after <= self.limit


@dataclass(frozen=True, slots=True)
class Overconfidence:
    """By what factor the true deviation of one form exceeds the one claimed: at the end, at worst, when."""

    name: str
    end: float
    worst: float
    when: float


@dataclass(frozen=True, slots=True, eq=False)
class Mismatch:
    """A filter designed on another model: the model, its system, and what its errors are.

    ``demands``: requirements of the truth's file on what the filter follows, held against its true errors.
    """

    model: Model
    system: System
    history: MismatchHistory
    demands: tuple[Demand, ...] = ()

    @property
    def ratios(self) -> tuple[Overconfidence, ...]:
        """True over claimed deviation, by form."""
        found, t = self.history, self.history.t
        ratios = [
            [_ratio(float(a), float(b)) for a, b in zip(true, claimed, strict=True)]
            for true, claimed in zip(found.true.T, found.claimed.T, strict=True)
        ]
        worst = [max(range(len(t)), key=own.__getitem__) for own in ratios]
        return tuple(
            Overconfidence(name, own[-1], own[k], float(t[k]))
            for name, own, k in zip(found.names, ratios, worst, strict=True)
        )


def _ratio(true: float, claimed: float) -> float:
    if claimed > 0:
        return true / claimed
    return math.inf if true > 0 else 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Initial:
    """An initial error, by state of the truth, and the mean response to it."""

    error: Mapping[str, float]
    response: MeanResponse


@dataclass(frozen=True, slots=True, eq=False)
class Simulation:
    """The Kalman filter of one stage along an interval.

    Parameters
    ----------
    start, stop, default : the interval, and whether obscli chose it
    forms : what is followed, in the order of the history's columns
    sampling : by output
    assumed_step : the time between samples where nothing says how often there is one
    history : of the deviations
    times : to observability
    fraction : of the prior below which a deviation counts as small where nothing is required
    demands : requirements of the file on what is followed here
    unsaid : why there are no combinations and verdicts; empty where there are
    sampled : functions of time for which a sample motion was taken
    recorded : functions of time that files give
    monte_carlo, mismatch, initial : None: not asked for, or interrupted before
    feedback : what is fed back after each sample; None: nothing, output correction
    """

    start: float
    stop: float
    default: bool
    forms: tuple[FollowedForm, ...]
    sampling: tuple[Sampling, ...]
    assumed_step: float | None
    history: History
    times: tuple[TimeToObservability, ...]
    fraction: float
    demands: tuple[Demand, ...]
    unsaid: str
    sampled: tuple[str, ...]
    recorded: tuple[str, ...] = ()
    monte_carlo: MonteCarlo | None = None
    mismatch: Mismatch | None = None
    initial: Initial | None = None
    feedback: Feedback | None = None

    @property
    def form(self) -> Mapping[str, FollowedForm]:
        """What is followed, by name."""
        return {one.name: one for one in self.forms}


@dataclass(frozen=True, slots=True, eq=False)
class SimulateResult:
    """One stage: its simulation, or what it lacks; ``interrupted``: not all of it was done."""

    model: Model
    system: System
    found: Simulation | NotComputed
    interrupted: bool = False

    @property
    def title(self) -> str:
        """The name of the model, and of the stage where it has one."""
        return stage_title(self.model, self.system)

    @property
    def failed(self) -> int:
        """How many requirements are not met at the end, by the filter of the model itself or by another."""
        if isinstance(self.found, NotComputed):
            return 0
        other = self.found.mismatch.demands if self.found.mismatch else ()
        return len({one.name for one in (*self.found.demands, *other) if not one.is_met})
