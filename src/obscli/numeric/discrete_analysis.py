"""Rank, gap and kernel of a discrete-time system at its steps, by shorter windows where growth drowns it."""

from __future__ import annotations

from typing import Final

import numpy as np

from obscli.model.system import System
from obscli.numeric.discrete_gramian import discrete_gramian, refined
from obscli.numeric.errors import UnfitRequestError
from obscli.numeric.horizon import Horizon
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import Array
from obscli.numeric.rates import Rates
from obscli.numeric.scaling import Scaling, scaled
from obscli.numeric.settings import Settings
from obscli.numeric.subspace import Subspaces, subspaces
from obscli.numeric.windows import joined, shortened


_PROBES: Final = 18


def discrete_subspaces(
    numeric: NumericSystem, system: System, horizon: Horizon, settings: Settings, scaling: Scaling
) -> tuple[Subspaces, Rates]:
    """Return rank, gap and kernel at every step, and how fast states change from step to step.

    Raises
    ------
    UnfitRequestError
        where a method of continuous time is asked for
    NotComputableError
        where a coefficient does not exist at some step, or the steps are too many
    """
    if settings.method != "square-root":
        raise UnfitRequestError(
            f"--gramian {settings.method} integrates in continuous time; a discrete-time model has "
            "--gramian square-root"
        )
    if settings.rtol is not None:
        raise UnfitRequestError("the Gramian of a discrete-time model has no step error: leave out --rtol")

    def at(k: float, window: float) -> Subspaces:
        return subspaces(scaled(refined(numeric, k, horizon.stop, window), system, scaling))

    whole = subspaces(scaled(discrete_gramian(numeric, horizon.instants, horizon.stop), system, scaling))
    rates = step_rates(numeric, horizon)
    parts = shortened(whole, rates, at)
    return (joined(whole, parts) if parts else whole), rates


def step_rates(numeric: NumericSystem, horizon: Horizon) -> Rates:
    """Return rates per step: ln of how fast states grow; everything may change from one step to the next."""
    k: Array = np.unique(np.round(np.linspace(horizon.start, horizon.stop, _PROBES)))
    largest = float(np.abs(np.linalg.eigvals(numeric.matrices(k)[0])).max(initial=0.0))
    return Rates(coefficients=0.0, dynamics=1.0, backward=max(np.log(largest), 0.0) if largest else 0.0)
