"""Time to observability: from when on a standard deviation stays below a limit.

    T = min { t : σ(τ) ≤ limit for all τ ≥ t }

The limit is the accuracy asked for, where there is one, else a fraction of the prior's deviation. Instants
are those recorded: T is late by no more than the time between two of them.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from obscli.numeric.simulation_finding import Criterion, History, TimeToObservability


def times_to_observability(
    history: History, requirements: Mapping[str, float], fraction: float = 0.1
) -> tuple[TimeToObservability, ...]:
    """Return when each linear form is known well enough for good.

    Parameters
    ----------
    history : of the standard deviations
    requirements : deviations asked for, by the names of the forms
    fraction : of the prior's deviation, for forms without a requirement
    """
    found = []
    for i, name in enumerate(history.names):
        because: Criterion = "require" if name in requirements else "fraction"
        limit = requirements.get(name, fraction * float(history.prior[i]))
        found.append(TimeToObservability(name, limit, because, _reached(history, i, limit)))
    return tuple(found)


def _reached(history: History, i: int, limit: float) -> float | None:
    """Return the first instant recorded from which on σ is within the limit; None: it is not at the end."""
    if not np.isfinite(limit):
        return None
    above = np.flatnonzero(history.deviations[:, i] > limit)
    first = int(above[-1]) + 1 if len(above) else 0
    return float(history.t[first]) if first < len(history.t) else None
