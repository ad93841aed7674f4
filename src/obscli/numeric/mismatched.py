"""A Kalman filter designed on one model, run on another: what it claims, and what its errors are.

Signatures; the computation follows.
"""

from __future__ import annotations

from obscli.model.system import System
from obscli.numeric.linear_forms import Forms
from obscli.numeric.progress import Progress, silent
from obscli.numeric.schedule import Schedule
from obscli.numeric.simulation_finding import MismatchHistory


def mismatch_history(
    truth: System,
    filter_: System,
    truth_schedule: Schedule,
    filter_schedule: Schedule,
    forms: Forms,
    recorded: int = 500,
    progress: Progress = silent,
) -> MismatchHistory:
    """Return the claimed and the true deviations of forms in the filter's states."""
    raise NotImplementedError
