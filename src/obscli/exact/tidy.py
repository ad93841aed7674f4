"""Pairs of opposite angles with the same consequence, written as one condition.

phi = pi/2 and phi = -pi/2  →  cos(phi) = 0;  phi = 0 and phi = pi  →  sin(phi) = 0
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from obscli.model.expression import Apply, Symbol


if TYPE_CHECKING:
    from collections.abc import Sequence

    from obscli.exact.finding import CriticalValue

_PAIRS = {("pi/2", "-pi/2"): "cos", ("0", "pi"): "sin"}


def merge_opposite_angles(values: Sequence[CriticalValue]) -> list[CriticalValue]:
    """Return the values with pairs of opposite angles of equal kind and rank merged."""
    known = {value.condition: value for value in values}
    merged: dict[str, CriticalValue] = {}
    for value in values:
        name, _, text = value.condition.partition(" = ")
        for pair, function in _PAIRS.items():
            if text not in pair:
                continue
            other = known.get(f"{name} = {pair[1 - pair.index(text)]}")
            if other is not None and (other.kind, other.rank) == (value.kind, value.rank):
                condition = f"{function}({name}) = 0"
                both = (*other.values, *value.values)
                zero = Apply(function, Symbol(name))
                merged[condition] = replace(value, condition=condition, zero=zero, values=both)
                break
        else:
            merged[value.condition] = value
    return list(merged.values())
