"""Two trajectories that no measurement can tell apart, and about which a false claim says they differ.

They differ by a solution n' = A n that starts in an unobservable direction: H n = 0 all along it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from obscli.checks.exact_claim import Exact
from obscli.checks.witness import Witness
from obscli.core.check import Counterexample, Trajectories
from obscli.model.system import Covector
from obscli.numeric.errors import NotComputableError
from obscli.numeric.program import Array
from obscli.numeric.trajectory import follow


_INSTANTS: Final = 5


def with_trajectories(exact: Exact, witness: Witness | str) -> Counterexample | None:
    """Return the counterexample with the trajectories in numbers, where they can be computed."""
    one = exact.counterexample
    if one is None or isinstance(witness, str) or exact.direction is None or exact.claimed is None:
        return one
    try:
        return replace(one, trajectories=_trajectories(witness, exact.direction, exact.claimed))
    except (NotComputableError, np.linalg.LinAlgError):
        return one


def _trajectories(witness: Witness, direction: Covector, claimed: Covector) -> Trajectories | None:
    numeric = witness.numeric
    start = numeric.horizon.start
    system = numeric.system
    initial = system.covectors([direction], np.array([start]))[0][0, 0]
    if not np.isfinite(initial).all():
        return None
    found = follow(numeric, initial, _INSTANTS)
    rows = system.covectors([claimed], found.instants)[0][:, 0]
    values: Array = np.einsum("kn,kn->k", rows, found.states)
    if not np.isfinite(values).all():
        return None
    names = system.system.state_names
    moved = np.flatnonzero(np.abs(found.states).max(axis=0) > 0)
    return Trajectories(
        instants=tuple(float(t) for t in found.instants),
        difference={names[j]: tuple(float(x) for x in found.states[:, j]) for j in moved},
        claim=tuple(float(v) for v in values),
        output=found.output,
    )
