"""What is hidden followed in floating point, where algebra leaves its fate open, and judged."""

from __future__ import annotations

from dataclasses import replace

from obscli.checks.detectability import Detectability, seen_detectability
from obscli.exact.structure_finding import Structure
from obscli.model.system import System
from obscli.numeric.hidden_motion import hidden_motion
from obscli.numeric.horizon import Horizon


def followed(system: System, structure: Structure, horizon: Horizon) -> Detectability:
    """Return the verdict over one period from the start of a horizon, or on its window where there is none.

    Raises
    ------
    NotComputableError
        where hidden errors cannot be followed
    """
    start, period = horizon.start, structure.period
    stop = horizon.stop if period is None else start + period
    motion = hidden_motion(system, structure.directions, start, stop, period=period is not None)
    found = seen_detectability(structure, motion)
    left_open = ", ".join(one.name for one in system.functions if one.derivative is None)
    return (
        replace(found, scope=f"{found.scope}, with a sample motion for {left_open}") if left_open else found
    )
