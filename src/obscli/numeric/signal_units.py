"""Samples that look as if they were in other units than they are taken in: degrees, milliseconds, turns.

Nothing is converted by itself, and nothing here is certain: these are questions to whoever wrote the file.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import Final

import numpy as np

from obscli.core.number import short
from obscli.model.expression import Apply, Expression, Sum, Symbol, postorder
from obscli.model.signal_file import SignalColumn, SignalFile
from obscli.model.system import System
from obscli.numeric.errors import NotComputableError
from obscli.numeric.program import Array, constant_value
from obscli.numeric.signals import samples_of


#: Full turns in radians and in degrees, how near to one a jump is, and rounding.
_TURNS: Final = (2 * np.pi, 360.0)
_NEAR: Final = 0.1
_ROUNDED: Final = 1e-6

#: Names of columns that say a unit, and for times the factor to seconds.
_DEGREES: Final = re.compile(r"(?:^|[^a-z])deg(?:s|rees?)?(?:[^a-z]|$)|°", re.IGNORECASE)
_FACTORS: Final = {"ms": "1e-3", "msec": "1e-3", "us": "1e-6", "usec": "1e-6", "ns": "1e-9", "nsec": "1e-9"}
_PLAIN: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_.]*")
_WORDS: Final = re.compile(r"[a-z]+", re.IGNORECASE)

#: Larger angles, without a turn taken out, are none in radians.
_LARGEST: Final = 4 * np.pi


def doubts(system: System) -> tuple[str, ...]:
    """Return what looks like another unit in the files of a system, in sentences."""
    try:
        samples = samples_of(system)
    except NotComputableError:  # which is told where they are used
        return ()
    angles = _angles(system)
    found: list[str] = []
    for file, one in zip(system.signals, samples, strict=True):
        found += _of_time(file)
        columns = {column.name: column for column in file.columns}
        for k, name in enumerate(one.names):
            found += _of_column(columns[name], one.values[:, k], is_angle=name in angles)
    return tuple(found)


def _of_time(file: SignalFile) -> Iterator[str]:
    units = [word for word in map(str.lower, _WORDS.findall(file.time)) if word in _FACTORS]
    if units and file.factor is None:
        yield (
            f"the times of {file.file.name} are taken as they are in '{file.time}': in {units[-1]}? (time: "
            f"{{column: {_quoted(file.time)}, factor: {_FACTORS[units[-1]]}}})"
        )


def _of_column(column: SignalColumn, values: Array, *, is_angle: bool) -> Iterator[str]:
    turn = _turn(values)
    if is_angle and column.unwrap is None and turn is not None:
        yield (
            f"{column.name} jumps by about a full turn between samples, which is taken for motion "
            f"(column: {_quoted(column.column)}, unwrap: {_in_file(turn, column)})"
        )
    if column.unwrap is None:
        large = turn == _TURNS[1] or np.abs(values).max() > _LARGEST
    else:
        large = constant_value(column.unwrap, {}) > _LARGEST
    if column.factor is None and is_angle and (large or _DEGREES.search(column.column)):
        yield (
            f"{column.name} is taken in radians and goes from {short(float(values.min()), 4)} to "
            f"{short(float(values.max()), 4)}: in degrees? (column: {_quoted(column.column)}, factor: pi/180)"
        )


def _in_file(turn: float, column: SignalColumn) -> str:
    """Return a full turn in the units of the file, as it is to be written."""
    size = abs(turn / (1.0 if column.factor is None else constant_value(column.factor, {})))
    known = {"2*pi": 2 * np.pi, "360": 360.0}
    return next((text for text, one in known.items() if abs(size / one - 1) < _ROUNDED), short(size, 6))


def _quoted(name: str) -> str:
    """Return a name as it stands in a file: in quotes where it has to."""
    return name if _PLAIN.fullmatch(name) else json.dumps(name, ensure_ascii=False)


def _turn(values: Array) -> float | None:
    """Return the full turn by which values jump that stay within one, None where they do not."""
    largest = float(np.abs(np.diff(values)).max())
    spread = float(np.ptp(values))
    for turn in _TURNS:
        if (1 - _NEAR) * turn <= largest and spread <= (1 + _ROUNDED) * turn:
            return turn
    return None


def _angles(system: System) -> frozenset[str]:
    """Return the functions of which trigonometric functions are taken: as they are, or in a sum."""
    entries: list[Expression] = [*system.A.entries.values(), *system.H.entries.values()]
    found = set()
    for node in postorder(*entries):
        if isinstance(node, Apply) and node.function in {"sin", "cos", "tan"}:
            terms = node.argument.terms if isinstance(node.argument, Sum) else (node.argument,)
            found |= {term.name for term in terms if isinstance(term, Symbol)}
    return frozenset(found)
