"""A solution of x' = A x, or x(k+1) = F x(k), followed from a given state, and what the outputs show of it.

x(b) = Φ(a, b)⁻¹ x(a)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from obscli.numeric.analysis import Numeric
from obscli.numeric.numeric_system import NumericSystem
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
    if system.system.discrete:
        instants = np.unique(np.round(instants))
        return _of_parts(system, instants, _stepped(system, instants, parts))
    found = [parts]
    edges = edges_of(horizon.start, instants[1:], longest_step(numeric.rates), _MOST_STEPS)
    for piece in panels(system, edges, Effort(_STEP_ERROR, _MOST_STEPS)):
        for end, rows in zip(piece.ends, piece.transition, strict=True):
            phi = np.eye(system.n)
            phi[system.moving] = rows
            parts = np.linalg.solve(phi, parts)
            if end == instants[len(found)]:
                found.append(parts)
    return _of_parts(system, instants, np.array(found))


def _stepped(system: NumericSystem, instants: Array, parts: Array) -> Array:
    """Return x(k+1) = F(k) x(k) at steps, shape (k, n, c)."""
    found = [parts]
    for k, F in zip(*_dynamics(system, instants), strict=True):
        parts = F @ parts
        if k + 1 == instants[len(found)]:
            found.append(parts)
    return np.array(found)


def _dynamics(system: NumericSystem, instants: Array) -> tuple[Array, Array]:
    """Return the steps before the last instant, and F at each."""
    every = np.arange(instants[0], instants[-1])
    return every, system.matrices(every)[0]


def _of_parts(system: NumericSystem, instants: Array, states: Array) -> Trajectory:
    """Return the trajectory that is the sum of parts, one for each initial state, (k, n, c)."""
    H = system.matrices(instants)[1]
    outputs = H @ states
    whole, alone = np.abs(outputs.sum(axis=2)).max(initial=0.0), np.abs(outputs).sum(axis=2).max(initial=0.0)
    possible = np.abs(H).max(initial=0.0) * np.abs(states).max(initial=0.0)
    of = alone if alone > _ROUNDING * possible else possible
    return Trajectory(instants, states.sum(axis=2), float(whole / of) if of else 0.0)
