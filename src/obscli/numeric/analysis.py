"""The numerical pipeline for one system: the Gramian at its instants, rank, gap and kernel at each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Final, TypeAlias

import numpy as np

from obscli.model.system import System
from obscli.numeric.discrete_analysis import discrete_subspaces
from obscli.numeric.errors import NotComputableError, TooManyStepsError, UnfitRequestError
from obscli.numeric.gramian import Gramian, Method
from obscli.numeric.horizon import Horizon, horizon_of
from obscli.numeric.lifted_gramian import lifted_gramian
from obscli.numeric.lyapunov import lyapunov_gramian
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import Array, Flags
from obscli.numeric.quadrature import quadrature_gramian
from obscli.numeric.rates import Rates, rates_of
from obscli.numeric.scaling import Scaling, chosen_scaling, scaled
from obscli.numeric.settings import Effort, Settings
from obscli.numeric.square_root import square_root_gramian
from obscli.numeric.subspace import Subspaces, subspaces
from obscli.numeric.transition import NODES, longest_step
from obscli.numeric.windows import joined, shortened, windowed


Progress: TypeAlias = Callable[[str], None]

Way: TypeAlias = Callable[[NumericSystem, float, Array, Rates, Effort], Gramian]

METHODS: Final[Mapping[Method, Way]] = {
    "square-root": square_root_gramian,
    "lyapunov": lyapunov_gramian,
    "quadrature": quadrature_gramian,
}

#: Steps made for the whole interval, or for the windows of all instants together: so many, and fewer where
#: the states that move are many, so that the multiplications stay below this.
MOST_STEPS: Final = 20_000
FEWEST_STEPS: Final = 10
_MULTIPLICATIONS: Final = 3e10
_SWEEPS: Final = 20

_PROBES: Final = 18


@dataclass(frozen=True, eq=False)
class Numeric:
    """What the numerical side finds about one system.

    Parameters
    ----------
    system : the system in floating point
    settings : as asked
    scaling : the units in force
    horizon : the instants
    rates : how fast the system is
    spaces : rank, gap and kernel at every instant
    """

    system: NumericSystem
    settings: Settings
    scaling: Scaling
    horizon: Horizon
    rates: Rates
    spaces: Subspaces

    @cached_property
    def rank(self) -> int | None:
        """The largest rank decided at any instant, None where there is none: longer windows show more."""
        decided = self.spaces.rank[self.spaces.decided]
        return int(decided.max()) if decided.size else None

    @cached_property
    def conclusive(self) -> Flags:
        """At which instants the rank is decided and has reached its value, shape (N,)."""
        reached: Flags = self.spaces.rank == (-1 if self.rank is None else self.rank)
        return self.spaces.decided & reached

    @property
    def window(self) -> float | None:
        """The shortest window where some are shorter than the whole interval, else None."""
        ends = self.spaces.gramian.starts
        lengths = np.abs(self.horizon.instants - ends)
        discrete = self.horizon.end is not None
        shorter = lengths[ends < self.horizon.stop if discrete else ends > self.horizon.start]
        return float(shorter.min()) if shorter.size else None


def analyze(system: System, settings: Settings, progress: Progress = lambda _: None) -> Numeric:
    """Find rank, gap and kernel of the Gramian at the instants of a system.

    Raises
    ------
    NotComputableError
        where a parameter has no value, the interval is none, a coefficient does not exist, …
    """
    horizon = horizon_of(system, settings.wanted)
    scaling = chosen_scaling(system, settings.scaling)
    numeric = NumericSystem(system, horizon.start, horizon.stop)
    if system.discrete:
        progress(f"Gramian at {len(horizon.instants)} steps")
        spaces, rates = discrete_subspaces(numeric, system, horizon, settings, scaling)
        return Numeric(numeric, settings, scaling, horizon, rates, spaces)
    rates = rates_of(numeric, np.linspace(horizon.start, horizon.stop, _PROBES)[1:-1])
    progress(f"Gramian at {len(horizon.instants)} instants")

    steps, way = affordable_steps(numeric), _way(settings)

    def spaces_of(start: float, instants: Array, most_steps: int) -> Subspaces:
        effort = Effort(settings.step_error, most_steps)
        found = way(numeric, start, instants, rates, effort)
        return subspaces(scaled(found, system, scaling))

    def at(t: float, w: float) -> Subspaces:
        return spaces_of(max(horizon.start, t - w), np.array([t]), max(steps // len(horizon.instants), 1))

    try:
        spaces = spaces_of(horizon.start, horizon.instants, steps)
    except TooManyStepsError as whole:
        progress("Gramian on windows: the whole interval would take too many steps")
        length = max(steps / len(horizon.instants) / 4, 1.0) * longest_step(rates)
        try:
            spaces = windowed(horizon.instants, length, at)
        except TooManyStepsError:
            raise whole from None
    found = Numeric(numeric, settings, scaling, horizon, rates, spaces)
    parts = shortened(spaces, rates, at)
    return replace(found, spaces=joined(spaces, parts)) if parts else found


def _way(settings: Settings) -> Way:
    if settings.method != "lift":
        return METHODS[settings.method]
    if settings.lift is None:
        raise UnfitRequestError("--gramian lift needs a stationary system with the same outputs")
    if settings.rtol is not None:
        raise UnfitRequestError("--gramian lift makes no step error: leave out --rtol")
    return partial(lifted_gramian, settings.lift)


def affordable_steps(system: NumericSystem) -> int:
    """Return how many steps are made at the most."""
    p = len(system.moving)
    one = NODES * p * p * system.n * _SWEEPS
    return MOST_STEPS if not one else int(min(MOST_STEPS, max(FEWEST_STEPS, _MULTIPLICATIONS / one)))


__all__ = ["NotComputableError", "Numeric", "analyze"]
