"""The covariance of the Kalman filter along an interval, as a square root.

Signatures; the computation follows.
"""

from __future__ import annotations

from obscli.model.system import System
from obscli.numeric.linear_forms import Forms
from obscli.numeric.program import Array
from obscli.numeric.progress import Progress, silent
from obscli.numeric.schedule import Schedule
from obscli.numeric.simulation_finding import History


def covariance_history(
    system: System, schedule: Schedule, forms: Forms, recorded: int = 500, progress: Progress = silent
) -> History:
    """Return the standard deviations of linear forms along the interval of a schedule."""
    raise NotImplementedError


def roots_at(system: System, schedule: Schedule, instants: Array) -> tuple[Array, Array]:
    """Return L with P = L Lᵀ after the samples up to each instant, and of the open loop, (k, n, n) each."""
    raise NotImplementedError
