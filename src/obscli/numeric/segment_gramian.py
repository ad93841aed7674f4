"""The Gramian over segments: one chain of square roots from the start of the first to the end of the last.

    W(t_j⁺) = J_j⁻ᵀ W(t_j) J_j⁻¹,    R⁺ = R J_j⁻¹

Within a segment it is carried like any other (``square_root``). An instant at the end of a segment is before
the jump. The whole state is carried through: nothing starts anew.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np

from obscli.model.expression import Expression
from obscli.model.system import Matrix, Segments, System
from obscli.numeric.analysis import Numeric, affordable_steps
from obscli.numeric.discrete_analysis import step_rates
from obscli.numeric.discrete_forward import forward_steps
from obscli.numeric.discrete_horizon import whole
from obscli.numeric.errors import NotComputableError
from obscli.numeric.horizon import Horizon, default_samples
from obscli.numeric.numeric_system import NumericSystem, constants_of
from obscli.numeric.program import EPS, Array, constant_value
from obscli.numeric.rates import Rates, rates_of
from obscli.numeric.scaling import chosen_scaling, scaled
from obscli.numeric.settings import Effort, Settings
from obscli.numeric.square_root import Chain, Snapshot, gathered, snapshots
from obscli.numeric.subspace import subspaces
from obscli.numeric.transition import edges_of, longest_step, panels


Progress: TypeAlias = Callable[[str], None]

#: Instants in one segment at least.
_FEWEST: Final = 4
_PROBES: Final = 18


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """One segment in numbers: its system, from ``start`` to ``stop``; ``jump``: J at the end, (n, n)."""

    name: str
    system: System
    start: float
    stop: float
    jump: Array | None


def pieces_of(segments: Segments) -> tuple[Piece, ...]:
    """Return the segments in numbers.

    Raises
    ------
    NotComputableError
        where a parameter has no value, a duration is not positive, or a jump cannot be undone
    """
    first = segments.parts[0].system
    values = constants_of(first)
    start = _number(segments.start, values, "the start of the segments")
    if first.discrete:
        start = whole(start, "the start of the segments")
    found = []
    for one in segments.parts:
        stop = _number(one.stop, values, f"the end of segment {one.name}")
        if one.system.discrete:
            stop = whole(stop, f"the end of segment {one.name}")
        if not stop > start:
            raise NotComputableError(f"the duration of segment {one.name} is not positive at these values")
        jump = None if one.jump is None else _matrix(one.jump, values, one.name)
        found.append(Piece(one.name, one.system, start, stop, jump))
        start = stop
    return tuple(found)


def left_open(pieces: Sequence[Piece]) -> tuple[str, ...]:
    """Return the functions of all segments for which a sample motion is taken."""
    motions = [NumericSystem(one.system, one.start, one.stop).motion for one in pieces]
    return tuple(dict.fromkeys(name for motion in motions if motion for name in motion.names))


def _number(value: Expression, values: dict[str, float], what: str) -> float:
    try:
        found = float(constant_value(value, values))
    except KeyError as missing:
        raise NotComputableError(f"{what}: {missing.args[0]} has no value (--set)") from None
    if not np.isfinite(found):
        raise NotComputableError(f"{what} is not finite")
    return found


def _matrix(jump: Matrix, values: dict[str, float], name: str) -> Array:
    found = np.zeros((jump.rows, jump.columns))
    for at, entry in jump.entries.items():
        found[at] = _number(entry, values, f"the jump after segment {name}")
    size = np.linalg.norm(found, axis=0)
    if not size.all() or not np.linalg.cond(found / size) < 1 / (jump.rows * EPS):
        raise NotComputableError(
            f"the jump after segment {name} cannot be undone: a combination of the states is lost in it, so "
            "that nothing can be said of the state before; let it keep the state (psi: psi + …)"
        )
    return found


def segment_numeric(
    segments: Segments, settings: Settings, samples: int | None = None, progress: Progress = lambda _: None
) -> tuple[Numeric, tuple[Piece, ...], Array]:
    """Return rank, gap and kernel at instants of all segments, and which instant ends each segment.

    Parameters
    ----------
    samples : instants over all segments; None: the file's, or the default

    Raises
    ------
    NotComputableError
        as ``pieces_of``, or where a segment cannot be integrated
    """
    pieces = pieces_of(segments)
    given = pieces[0].system.interval
    count = samples or (given.samples if given else None) or default_samples(pieces[0].system.n)
    instants = _instants(pieces, count)
    chain: Chain | None = None
    found: list[Snapshot] = []
    rates, last = [], None
    for piece, own in zip(pieces, instants, strict=True):
        progress(f"Gramian over the segments: {piece.name}")
        last = NumericSystem(piece.system, piece.start, piece.stop)
        if chain is None:
            chain = Chain(last)
        chain.enter(last)
        rates.append(_rates(last, piece))
        if piece.system.discrete:
            steps = forward_steps(last, piece.start, piece.stop, first=piece is pieces[0])
        else:
            effort = Effort(settings.step_error, affordable_steps(last))
            edges = edges_of(piece.start, own, longest_step(rates[-1]), effort.most_steps)
            steps = panels(last, edges, effort)
        found += snapshots(steps, chain, own)
        if piece.jump is not None:
            chain.jump(np.asarray(np.linalg.inv(piece.jump), dtype=float))
    assert last is not None
    whole = np.concatenate(instants)
    gramian = gathered(found, pieces[0].start, whole)
    scaling = chosen_scaling(pieces[0].system, settings.scaling)
    spaces = subspaces(scaled(gramian, pieces[0].system, scaling))
    horizon = Horizon(pieces[0].start, whole, "given")
    numeric = Numeric(last, settings, scaling, horizon, _fastest(rates), spaces)
    return numeric, pieces, np.cumsum([len(own) for own in instants]) - 1


def _rates(system: NumericSystem, piece: Piece) -> Rates:
    if piece.system.discrete:
        return step_rates(system, Horizon(piece.start, np.array([piece.stop]), "given"))
    return rates_of(system, np.linspace(piece.start, piece.stop, _PROBES)[1:-1])


def _instants(pieces: Sequence[Piece], count: int) -> list[Array]:
    """Return instants of every segment, its end the last of them, about so many in all."""
    total = pieces[-1].stop - pieces[0].start
    shares = [max(_FEWEST, round(count * (one.stop - one.start) / total)) for one in pieces]
    found = []
    for one, share in zip(pieces, shares, strict=True):
        own = one.start + (one.stop - one.start) * np.arange(1, share + 1) / share
        own[-1] = one.stop
        if one.system.discrete:
            own = np.unique(np.maximum(np.round(own), one.start + 1))
        found.append(own)
    return found


def _fastest(rates: Sequence[Rates]) -> Rates:
    return Rates(
        max(one.coefficients for one in rates),
        max(one.dynamics for one in rates),
        max(one.backward for one in rates),
    )
