"""What is found of one stage window by window."""

from __future__ import annotations

from dataclasses import dataclass

from obscli.exact.motion import MotionNeeds
from obscli.model.system import Model, System
from obscli.numeric.finding import NotComputed
from obscli.numeric.horizon import Horizon
from obscli.numeric.local_windows import Sampling
from obscli.numeric.piecewise_constant import PiecewiseConstant
from obscli.numeric.window_measures import WindowValues
from obscli.numeric.window_scaling import WindowScaling
from obscli.pipelines.request import WindowsRequest
from obscli.pipelines.stage_result import stage_title


@dataclass(frozen=True, slots=True)
class Gain:
    """Where along the interval a state or quantity gains most.

    Parameters
    ----------
    target : its name
    key : by what it is judged: ``posterior-ratio``, or ``equivalent-singular-value`` where there is no prior
    best, at : the best value, and the start of its window
    ranges : where windows gain at least half as much, from start to start; empty: none gains
    """

    target: str
    key: str
    best: float
    at: float
    ranges: tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True, eq=False)
class Windows:
    """The windows of one stage.

    Parameters
    ----------
    names : of the linear forms in order: states, quantities
    shown : which of them tables and figures are about
    values : of the windows kept, every ``every``-th
    segments : the interval as piecewise constant; or why not
    gains : by state and quantity
    warnings : what must not be missed
    """

    horizon: Horizon
    sampling: Sampling
    scaling: WindowScaling
    names: tuple[str, ...]
    shown: tuple[int, ...]
    values: WindowValues
    every: int
    segments: PiecewiseConstant | NotComputed
    gains: tuple[Gain, ...]
    warnings: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class WindowsResult:
    """One stage, and its windows or why there are none; ``needs``: which motion its states need."""

    model: Model
    system: System
    request: WindowsRequest
    found: Windows | NotComputed
    needs: MotionNeeds | None = None

    @property
    def title(self) -> str:
        """The name of the model, and of the stage where it has one."""
        return stage_title(self.model, self.system)
