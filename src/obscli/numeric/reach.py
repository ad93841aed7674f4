"""Which states depend on which in the course of time: x_i(t) on x_j(a), whatever the interval.

reach = closure of the pattern of I + A:    Φ(t, a) and Φ(a, t) are zero outside of it, exactly
"""

from __future__ import annotations

import numpy as np

from obscli.model.system import System
from obscli.numeric.program import Flags


def reach(system: System) -> Flags:
    """Return whether a state (row) may depend on another (column), shape (n, n)."""
    found = np.eye(system.n, dtype=bool)
    for place in system.A.entries:
        found[place] = True
    while True:
        wider = (found.astype(float) @ found) > 0
        if (wider == found).all():
            return found
        found = wider
