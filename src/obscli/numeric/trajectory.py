"""A solution of x' = A x followed from a given state, and how much of it the outputs show.

x(b) = Φ(a, b)⁻¹ x(a)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from obscli.numeric.analysis import Numeric
from obscli.numeric.program import Array
from obscli.numeric.settings import Effort
from obscli.numeric.transition import edges_of, longest_step, panels


_STEP_ERROR: Final = 1e-12
_MOST_STEPS: Final = 20_000

#: Outputs this small, relative to what states as large could cause, may be rounding.
_ROUNDING: Final = 1e-12


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """States (k, n) at instants (k,).

    ``output``: the largest output, relative to the sum of those that each initial state alone would cause; to
    what states as large could cause at all where these are all rounding.
    """

    instants: Array
    states: Array
    output: float


def follow(numeric: Numeric, initial: Array, count: int) -> Trajectory:
    """Return the solution through a state at the start of the interval.

    Parameters
    ----------
    initial : x(t0), shape (n,)
    count : at how many instants, evenly from t0 to the end, at least two

    Raises
    ------
    NotComputableError
        where the steps would be too many
    """
    system, horizon = numeric.system, numeric.horizon
    instants = np.linspace(horizon.start, horizon.stop, count)
    parts = np.diag(initial.astype(float))[:, initial != 0]  # one column for each initial state that is not 0
    found = [parts]
    edges = edges_of(horizon.start, instants[1:], longest_step(numeric.rates), _MOST_STEPS)
    for piece in panels(system, edges, Effort(_STEP_ERROR, _MOST_STEPS)):
        for end, rows in zip(piece.ends, piece.transition, strict=True):
            phi = np.eye(system.n)
            phi[system.moving] = rows
            parts = np.linalg.solve(phi, parts)
            if end == instants[len(found)]:
                found.append(parts)
    H, states = system.matrices(instants)[1], np.array(found)
    outputs = H @ states
    whole, alone = np.abs(outputs.sum(axis=2)).max(initial=0.0), np.abs(outputs).sum(axis=2).max(initial=0.0)
    possible = np.abs(H).max(initial=0.0) * np.abs(states).max(initial=0.0)
    of = alone if alone > _ROUNDING * possible else possible
    return Trajectory(instants, states.sum(axis=2), float(whole / of) if of else 0.0)
