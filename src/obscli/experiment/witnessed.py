"""The numerical side of an experiment: the Gramian of every run, the shared states' part of it, all joined.

At a fraction f of every run's duration the information on the shared states adds up to one Gramian over
them, the runs' other states eliminated. It knows nothing of the exact rows M, and so can witness for them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np

from obscli.model.system import Run, System
from obscli.numeric.analysis import Numeric
from obscli.numeric.finding import NotComputed
from obscli.numeric.horizon import Horizon
from obscli.numeric.marginal import Marginal, joined, marginal
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import Array, Counts
from obscli.numeric.rates import Rates
from obscli.numeric.scaling import chosen_scaling, scaled
from obscli.numeric.settings import Settings
from obscli.numeric.subspace import subspaces


#: Finds the Gramian of the system of a run.
Look: TypeAlias = Callable[[System], Numeric | NotComputed]

#: The fractions of the runs at which they are joined.
FRACTIONS: Final = 10


@dataclass(frozen=True, eq=False)
class Witnessed:
    """The Gramians of all runs and what they say together.

    Parameters
    ----------
    runs : the Gramian of every run, or why there is none
    together : all runs joined, by the fraction of them that is over
    after : after each run, the runs before it and itself over
    reason : why the runs cannot be joined; empty where they are
    dropped : how many directions of the states that start anew were taken as not seen at all
    """

    runs: tuple[Numeric | NotComputed, ...]
    together: Numeric | None
    after: Numeric | None
    reason: str = ""
    dropped: int = 0


def witnessed(runs: Sequence[Run], system: System, look: Look, settings: Settings) -> Witnessed:
    """Find the Gramians of all runs and join them.

    Parameters
    ----------
    system : the static system over the shared states, x' = 0
    look : finds the Gramian of one run
    settings : for the scaling in which the joint rank is decided
    """
    found = tuple(look(run.system) for run in runs)
    for run, one in zip(runs, found, strict=True):
        if isinstance(one, NotComputed):
            return Witnessed(found, None, None, f"run {run.name}: {one.reason}")
    numeric = [one for one in found if isinstance(one, Numeric)]
    if not system.n:
        return Witnessed(found, None, None, "no state is shared")
    count = min(FRACTIONS, *(len(one.horizon.instants) for one in numeric))
    fractions = np.arange(1, count + 1) / count
    parts = [_parts(one, run.system, system, fractions) for run, one in zip(runs, numeric, strict=True)]
    together = [[part[j] for part in parts] for j in range(count)]
    after = [[part[-1] for part in parts[: k + 1]] for k in range(len(parts))]
    return Witnessed(
        found,
        _joint(system, settings, fractions, together),
        _joint(system, settings, np.arange(1.0, len(runs) + 1), after),
        dropped=max(part[-1].dropped for part in parts),
    )


def _parts(numeric: Numeric, run: System, shared: System, fractions: Array) -> list[Marginal]:
    """Return the shared states' information at fractions of one run."""
    place = {name: j for j, name in enumerate(run.state_names)}
    kept: Counts = np.array([place[name] for name in shared.state_names], dtype=int)
    last = len(numeric.horizon.instants)
    instants = np.ceil(fractions * last - 1e-9).astype(int) - 1
    found = {int(i): marginal(numeric.spaces, int(i), kept) for i in np.unique(instants)}
    return [found[int(i)] for i in instants]


def _joint(system: System, settings: Settings, labels: Array, parts: Sequence[Sequence[Marginal]]) -> Numeric:
    scaling = chosen_scaling(system, settings.scaling)
    spaces = subspaces(scaled(joined(labels, parts), system, scaling))
    numeric = NumericSystem(system, 0.0, float(labels[-1]))
    still = Rates(0.0, 0.0, 0.0)
    return Numeric(numeric, settings, scaling, Horizon(0.0, labels, "given"), still, spaces)
