"""Orientation that changes between two segments without a segment or jump for the motion.

A `let` entry R that is a rotation (R Rᵀ = I, det R = 1) just before and just after the end of a segment, and
is not the same there, has turned by the angle α of R⁺ Rᵀ in no time. What the motion itself does to states
that move (errors of the rate times the angle) is then missing, and more may seem observable than is. Where
states only stand still nothing is missed. Entries are compared in balls: what differs, differs.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from flint import arb, arb_mat

from obscli.core.number import counted
from obscli.exact.ball import OutsideDomainError, precision
from obscli.exact.ball_transition import BallTime, ball_number
from obscli.model.covector import scope_of
from obscli.model.specialise import at_nominal


if TYPE_CHECKING:
    from obscli.model.expression import Expression
    from obscli.model.system import Segment, Segments, System
    from obscli.model.tensor import Tensor


_BITS: Final = 128
_PLANE: Final = 2
_SPACE: Final = 3
_SHOWN: Final = 4


@dataclass(frozen=True, slots=True)
class Turn:
    """A rotation that turns by an angle between two segments, at an instant; ``moving``: states that move."""

    name: str
    before: str
    after: str
    t: float
    degrees: float
    moving: tuple[str, ...]

    @property
    def text(self) -> str:
        """The warning in words."""
        some = ", ".join(self.moving[:_SHOWN]) + (", …" if len(self.moving) > _SHOWN else "")
        return (
            f"{self.name} turns by {self.degrees:.4g}° between '{self.before}' and '{self.after}' "
            f"(t = {self.t:.6g}) in no time: what that motion does to the states that move ({some}) is "
            "missing, and combinations may seem observable that are not; put a segment for the motion "
            f"between them, or give '{self.before}' a `jump`"
        )


def turned_between(segments: Segments) -> tuple[Turn, ...]:
    """Return the rotations that turn between segments without a jump, at the file's values."""
    found: list[Turn] = []
    with precision(_BITS, 2):
        for one, other in zip(segments.parts, segments.parts[1:], strict=False):
            if one.jump is None:
                found += _turns(segments, one, other)
    return tuple(found)


def summary(turns: tuple[Turn, ...]) -> tuple[str, ...]:
    """Return the warnings, those after the first few of one name counted only."""
    told: list[str] = []
    for name in dict.fromkeys(one.name for one in turns):
        own = [one for one in turns if one.name == name]
        told.append(own[0].text + (f" ({counted(len(own), 'such place')} in all)" if len(own) > 1 else ""))
    return tuple(told)


def _turns(segments: Segments, one: Segment, other: Segment) -> Iterator[Turn]:
    moving = moving_states(one.system, other.system)
    first = segments.parts[0].system
    try:
        t = ball_number(first, at_nominal(first).expression(one.stop))
    except (KeyError, OutsideDomainError):
        return
    if moving:
        for name, turn in rotations_apart(one.system, t, other.system, t):
            yield Turn(name, one.name, other.name, float(t), _degrees(turn), moving)


def rotations_apart(one: System, t: arb, other: System, s: arb) -> Iterator[tuple[str, arb_mat]]:
    """Yield rotations that differ between two systems, each at an instant, with R⁺ Rᵀ; in ``precision``."""
    before, after = _matrices(one), _matrices(other)
    for name in before.keys() & after.keys():
        R, turned = _rotation(one, before[name], t), _rotation(other, after[name], s)
        if R is None or turned is None or R.nrows() != turned.nrows():
            continue
        if any(not entry.contains(0) for entry in (turned - R).entries()):
            yield name, turned * R.transpose()


def moving_states(*systems: System) -> tuple[str, ...]:
    """Return the states that move in any of the systems."""
    rows = {i for one in systems for i, _ in one.A.entries}
    return tuple(name for i, name in enumerate(systems[0].state_names) if i in rows)


def _matrices(system: System) -> Mapping[str, Tensor]:
    """Return what the names of a system stand for, where it is a small square matrix free of states."""
    return {
        name: value
        for name, value in scope_of(system).values.items()
        if value.shape in {(_PLANE, _PLANE), (_SPACE, _SPACE)} and not any(e.linear for e in value.entries)
    }


def _rotation(system: System, value: Tensor, t: arb) -> arb_mat | None:
    """Return the matrix at an instant where it may be a rotation, None where it is none or has no value."""
    special = at_nominal(system)
    size = value.shape[0]
    try:
        point = BallTime(special.system(), t, 1)
        R = arb_mat(size, size, [_entry(point, special.expression(e.constant)) for e in value.entries])
    except (KeyError, OutsideDomainError):
        return None
    unit = R * R.transpose()
    for i in range(size):
        unit[i, i] -= 1
    return R if all(entry.contains(0) for entry in unit.entries()) and R.det() > 0 else None


def _entry(point: BallTime, node: Expression) -> arb:
    found: arb = point.value(node)[0]
    return found


def _degrees(turn: arb_mat) -> float:
    """Return the angle of a rotation, from 0 to 180."""
    trace = sum((turn[i, i] for i in range(turn.nrows())), arb(0))
    cosine = trace / 2 if turn.nrows() == _PLANE else (trace - 1) / 2
    middle = min(max(float(cosine.mid()), -1.0), 1.0)
    return float(arb(middle).acos() * 180 / arb.pi())
