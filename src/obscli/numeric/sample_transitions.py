"""Transition matrices from one instant to the next of a row of instants, by collocation.

Where coefficients move or the dynamics turn too fast for one panel from instant to instant, it takes several.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from obscli.numeric.dense_transition import dense_transitions
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import EPS, Array
from obscli.numeric.rates import rates_of
from obscli.numeric.settings import Effort
from obscli.numeric.transition import edges_of, longest_step, panels


#: The step error asked for, relative, and what a transition is off by in units of it.
STEP_ERROR: Final = 1e-12
_OFF: Final = 4.0

_MOST_PANELS: Final = 200_000
_PROBES: Final = 18


def sample_transitions(system: NumericSystem, t: Array) -> tuple[Array, Array]:
    """Return Φ(t_{g+1}, t_g) between g ascending instants, and what it may be off by, (g − 1, n, n) each.

    Raises
    ------
    NotComputableError
        where coefficients cannot be resolved, or steps would be too many
    """
    if len(t) < 2:
        return np.zeros((0, system.n, system.n)), np.zeros((0, system.n, system.n))
    probes = np.linspace(t[0], t[-1], _PROBES)[1:-1]
    edges = edges_of(float(t[0]), t[1:], longest_step(rates_of(system, probes)), _MOST_PANELS)
    effort = Effort(STEP_ERROR, 2 * _MOST_PANELS)
    edges = np.concatenate([t[:1], *(piece.ends for piece in panels(system, edges, effort))])
    found = np.tile(np.eye(system.n), (len(t) - 1, 1, 1))
    interval = np.searchsorted(t, edges[1:]) - 1
    for g, dense in zip(interval, dense_transitions(system, edges), strict=True):
        found[g, system.moving] = dense.forward(np.array([dense.stop]))[0] @ found[g]
    return found, (_OFF * STEP_ERROR + EPS) * np.abs(found)
