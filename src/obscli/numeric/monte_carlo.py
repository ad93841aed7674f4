"""Runs of a Kalman filter with random errors, all runs at once.

Signatures; the computation follows.
"""

from __future__ import annotations

from obscli.model.system import System
from obscli.numeric.linear_forms import Forms
from obscli.numeric.progress import Progress, silent
from obscli.numeric.schedule import Schedule
from obscli.numeric.simulation_finding import MonteCarlo


def monte_carlo(  # noqa: PLR0913 - the system, the runs, and what is kept of them
    system: System,
    schedule: Schedule,
    forms: Forms,
    runs: int,
    seed: int,
    recorded: int = 200,
    progress: Progress = silent,
    *,
    filter_: System | None = None,
    filter_schedule: Schedule | None = None,
) -> MonteCarlo:
    """Return how the errors of a filter on ``system`` spread, one of its own model or of ``filter_``."""
    raise NotImplementedError
