"""What a simulation is asked of an initial error and of feedback, read in the names of a system.

Importing this costs the floating-point libraries.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Final

import numpy as np

from obscli.model.covector import parse_scalar
from obscli.model.system import System
from obscli.numeric.feedback import Feedback
from obscli.numeric.numeric_system import NumericSystem, missing_values
from obscli.numeric.program import Array
from obscli.pipelines.reading import unknown
from obscli.pipelines.request import RequestError


_LIMIT: Final = re.compile(r"sigma\s*[<>]")
_MEANT: Final = {
    "<": "C a positive number: the fraction of its prior below which a state's deviation has to be",
    ">": "C a positive number: what a state's equivalent singular value has to exceed",
}


def initial_of(system: System, given: Sequence[tuple[str, str]], start: float, stop: float) -> Array | None:
    """Return the initial error, shape (n,): expressions at the start, not a number where none is given.

    None where nothing is given.

    Raises
    ------
    RequestError
        where a name is no state, or a value no number at the start
    ModelError
        where a text is no expression in the names of the system
    """
    if not given:
        return None
    states = list(system.state_names)
    for name, _ in given:
        parts = [one.name for one in system.states if one.vector == name]
        if parts:
            raise RequestError(f"--initial: {name} is a vector: give its components, {', '.join(parts)}")
        if name not in states:
            raise RequestError(unknown("--initial: no state", name, states))
    covector = {name: parse_scalar(system, text, f"--initial {name}") for name, text in given}
    without_value = [one.name for one in system.parameters if one.nominal is None]
    if without_value:
        raise RequestError(f"--initial: {missing_values(without_value)}")
    values = NumericSystem(system, start, stop).covectors([covector], np.array([start]))[0][0, 0]
    found = np.full(len(states), np.nan)
    for k, (name, value) in enumerate(zip(states, values, strict=True)):
        if not math.isfinite(value):
            raise RequestError(f"--initial {name}: no number at the start {start:.6g}")
        if name in covector:
            found[k] = value
    return found


def feedback_of(design: System, true: System, given: Sequence[str] | None) -> Feedback | None:
    """Return what is fed back.

    Parameters
    ----------
    given : None: nothing; empty: all; else states and vectors, one ``sigma>c``, one ``sigma<c``

    Raises
    ------
    RequestError
        where a name is not one of both systems, or the limit is no positive number
    """
    if given is None:
        return None
    limits = [one for one in given if _LIMIT.match(one)]
    below, above = (_limit(limits, sign) for sign in "<>")
    states: list[str] = []
    for name in (one for one in given if one not in limits):
        states += _states(design, true, name)
    return Feedback(tuple(dict.fromkeys(states)) or None, below, above)


def _limit(limits: Sequence[str], sign: str) -> float | None:
    found = [one for one in limits if sign in one]
    if not found:
        return None
    try:
        value = float(found[0].partition(sign)[2])
    except ValueError:
        value = math.nan
    if len(found) > 1 or not value > 0:
        raise RequestError(f"--feedback {', '.join(found)}: expected one sigma{sign}C, {_MEANT[sign]}")
    return value


def _states(design: System, true: System, name: str) -> list[str]:
    """Return the states of the filter that a name stands for."""
    found = [one.name for one in design.states if name in (one.name, one.vector)]
    if not found:
        raise RequestError(unknown("--feedback: the filter has no state", name, list(design.state_names)))
    lacking = [one for one in found if one not in true.state_names]
    if lacking:
        raise RequestError(
            f"--feedback {name}: the true model has no state {', '.join(lacking)}: nothing to correct"
        )
    return found
