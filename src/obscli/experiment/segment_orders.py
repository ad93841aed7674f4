"""Which segments in which order show most, the whole state carried through.

Every segment of the file is a manoeuvre, made once at the most. Moved in time it brings its own time along,
so that what it shows of the state at its own start, and its transition Φ_k, are the same wherever it stands:

    rows of an order (k_1, k_2, …):    R_{k_1},  R_{k_2} Φ_{k_1},  R_{k_3} Φ_{k_2} Φ_{k_1}, …

Rows are counted in balls: what is counted is independent. An order in which a rotation would turn in no time
is none. Orders are tried by their number of segments, the shorter before the longer ones.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from flint import arb, arb_mat

from obscli.checks.certified_segments import Echelon
from obscli.checks.turned_between import moving_states, rotations_apart
from obscli.exact.ball import precision
from obscli.exact.ball_transition import BallSegment, ball_number
from obscli.model.specialise import at_nominal


if TYPE_CHECKING:
    from obscli.model.system import Segment, Segments


_BITS: Final = 128
_TERMS: Final = 42

#: So many orders are tried, and so many of the best shown.
MOST_TRIED: Final = 2000
MOST_SHOWN: Final = 10


@dataclass(frozen=True, slots=True)
class Order:
    """Segments by name, how long all of them take, and how many independent rows there are after each."""

    names: tuple[str, ...]
    duration: float
    after: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Orders:
    """The orders that show most, the shortest first.

    Parameters
    ----------
    rank : how many independent combinations they show, at least
    target : as many as were looked for: those of the file's own order
    best : orders of the fewest segments that show ``rank``, by their duration
    tried : how many orders were looked at
    is_complete : whether all orders of no more segments were
    """

    rank: int
    target: int
    best: tuple[Order, ...]
    tried: int
    is_complete: bool


@dataclass(frozen=True, slots=True, eq=False)
class _Manoeuvre:
    """One segment: rows in the state at its start, its transition, its length, and what may follow it."""

    name: str
    rows: arb_mat
    transition: arb_mat
    duration: float
    followers: tuple[int, ...]


@dataclass(frozen=True, slots=True, eq=False)
class _Way:
    """An order on its way: what was made, what it shows, the transition so far."""

    made: tuple[int, ...]
    after: tuple[int, ...]
    echelon: Echelon
    carried: arb_mat


def segment_orders(segments: Segments, told: Callable[[str], None] = lambda _: None) -> Orders:
    """Return the shortest orders of the segments that show as much as the order of the file.

    Raises
    ------
    OutsideDomainError, KeyError, TooManyBallStepsError
        where a segment cannot be followed in ball arithmetic
    """
    with precision(_BITS, _TERMS + 2):
        told("segments in ball arithmetic")
        manoeuvres = _manoeuvres(segments)
        n = segments.parts[0].system.n
        start = _Way((), (), Echelon(), _identity(n))
        own = start
        for k in range(len(manoeuvres)):
            own = _with(own, k, manoeuvres)
        target = own.after[-1]
        return _searched(manoeuvres, start, target, told)


def _searched(
    manoeuvres: Sequence[_Manoeuvre], start: _Way, target: int, told: Callable[[str], None]
) -> Orders:
    """Try all orders of one segment, then of two, …, until some show the target."""
    ways, tried, complete = [start], 0, True
    best: list[_Way] = []
    while ways and complete:
        longer: list[_Way] = []
        for way in ways:
            allowed = manoeuvres[way.made[-1]].followers if way.made else range(len(manoeuvres))
            for k in allowed:
                if k in way.made:
                    continue
                if tried == MOST_TRIED:
                    complete = False
                    break
                tried += 1
                longer.append(_with(way, k, manoeuvres))
        told(f"{tried} orders of up to {len(longer[0].made) if longer else 0} segments")
        best = _better(best, longer)
        if best and best[0].after[-1] >= target:
            break
        ways = longer
    rank = best[0].after[-1] if best else 0
    found = sorted((_order(one, manoeuvres) for one in best), key=lambda one: one.duration)
    return Orders(rank, target, tuple(found[:MOST_SHOWN]), tried, complete)


def _better(best: list[_Way], ways: list[_Way]) -> list[_Way]:
    """Return the ways that show most; the shorter ones where longer ones show no more."""
    most = max((one.after[-1] for one in ways), default=-1)
    if best and best[0].after[-1] >= most:
        return best
    return [one for one in ways if one.after[-1] == most]


def _with(way: _Way, k: int, manoeuvres: Sequence[_Manoeuvre]) -> _Way:
    one = manoeuvres[k]
    echelon = way.echelon.copy()
    if echelon.rank < one.rows.ncols():
        echelon.add((one.rows * way.carried).tolist())
    return _Way((*way.made, k), (*way.after, echelon.rank), echelon, one.transition * way.carried)


def _order(way: _Way, manoeuvres: Sequence[_Manoeuvre]) -> Order:
    made = [manoeuvres[k] for k in way.made]
    return Order(tuple(one.name for one in made), sum(one.duration for one in made), way.after)


def _manoeuvres(segments: Segments) -> list[_Manoeuvre]:
    first = segments.parts[0].system
    values = at_nominal(first)
    stops = [ball_number(first, values.expression(one.stop)) for one in segments.parts]
    starts = [ball_number(first, values.expression(segments.start)), *stops[:-1]]
    tolerance = arb(2) ** (-(3 * _BITS) // 4)
    found = []
    for k, one in enumerate(segments.parts):
        motion = BallSegment(at_nominal(one.system).system(), _TERMS)
        echelon = Echelon()
        for rows in motion.rows(starts[k], first.n):
            echelon.add(rows.tolist())
        duration = ball_number(first, values.expression(one.duration))
        found.append(
            _Manoeuvre(
                one.name,
                arb_mat(echelon.rows) if echelon.rank else arb_mat(0, first.n),
                motion.transition(starts[k], duration, tolerance),
                float(duration),
                _followers(segments.parts, k, stops[k], starts),
            )
        )
    return found


def _followers(parts: Sequence[Segment], k: int, stop: arb, starts: Sequence[arb]) -> tuple[int, ...]:
    """Return the segments before which no rotation has to turn in no time."""
    one = parts[k].system
    return tuple(
        j
        for j, other in enumerate(parts)
        if j != k
        and not (
            moving_states(one, other.system) and any(rotations_apart(one, stop, other.system, starts[j]))
        )
    )


def _identity(n: int) -> arb_mat:
    return arb_mat(n, n, [int(i == j) for i in range(n) for j in range(n)])
