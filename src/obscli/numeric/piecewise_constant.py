"""A varying system taken as piecewise constant: local rank, total and stripped observability matrix.

Segment j, from t_j to t_{j+1} = t_j + D_j, keeps A_j, H_j of its start; Q_j is its observability matrix.

    TOM   [Q_1; Q_2 e^(A_1 D_1); …; Q_r e^(A_{r−1} D_{r−1}) … e^(A_1 D_1)]
    SOM   [Q_1; Q_2; …; Q_r]

Of a discrete-time system F_j^D_j takes the place of e^(A_j D_j), and F_j − I that of A_j below.

Where null(Q_j) ⊂ null(A_j) for all j, both have the same null space; else the SOM may miss what the TOM
shows. The condition is tested: ‖D⁻¹ A_j D N_j‖, N_j an orthonormal basis of null(Q_j D), against what N_j is
known to.

References
----------
D. Goshen-Meskin, I. Y. Bar-Itzhack, Observability analysis of piece-wise constant systems,
IEEE Trans. AES 28, 1992.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from obscli.numeric.gramian import Gramian, squared_rounding
from obscli.numeric.local_stack import LocalStack
from obscli.numeric.matrix_exponential import exponentials
from obscli.numeric.program import EPS, Array, Counts, Flags
from obscli.numeric.subspace import TOLERANCE, Subspaces, subspaces
from obscli.numeric.window_measures import identifiable


#: Numbers of segments, of either kind.
_Numbers: TypeAlias = NDArray[Any]

#: A transition matrix of a segment is off by so many roundings.
_EXPONENTIAL: Final = 8.0


@dataclass(frozen=True, slots=True, eq=False)
class Segments:
    """Some consecutive segments.

    Parameters
    ----------
    starts, durations : shape (k,)
    A, A_error : moving rows and their errors, shape (k, p, n); of a discrete-time system F − I
    stack : Q, its outputs weighed
    transition : moving rows of Φ over each, shape (k, p, n); None: exp(A D)
    """

    starts: Array
    durations: Array
    A: Array
    A_error: Array
    stack: LocalStack
    transition: Array | None = None


@dataclass(frozen=True, slots=True, eq=False)
class PiecewiseConstant:
    """What r segments show; ``total`` is of the TOM up to each segment, ``stripped`` of the SOM.

    Parameters
    ----------
    starts, stops : of the segments, shape (r,)
    local_rank : of Q_j, shape (r,)
    residual, known : ‖D⁻¹ A_j D N_j‖ in 1/time and the size below which it means nothing, shape (r,)
    total_rank, stripped_rank : shape (r,)
    total_values, stripped_values : their singular values after the last segment, shape (n,)
    since : the end of the segment from which on each linear form of the start is observable; not a number:
        never; shape (q,)
    decided : whether no rank lies in the grey zone between information and rounding
    """

    starts: Array
    stops: Array
    local_rank: Counts
    residual: Array
    known: Array
    total_rank: Counts
    stripped_rank: Counts
    total_values: Array
    stripped_values: Array
    since: Array
    decided: bool

    @property
    def violated(self) -> Flags:
        """Whether the condition fails in a segment, shape (r,)."""
        return self.residual > self.known

    @property
    def holds(self) -> bool:
        """Whether the condition holds in all segments, so that the SOM may stand for the TOM."""
        return not self.violated.any()


def piecewise_constant(
    portions: Iterable[Segments], moving: Array, units: Array, forms: Array
) -> PiecewiseConstant:
    """Analyse consecutive segments.

    Parameters
    ----------
    portions : all segments in order, some at a time
    moving : the moving states
    units : D, shape (n,)
    forms : linear forms of the state at the start, shape (q, n)
    """
    course = _Course(moving, units, forms)
    for one in portions:
        course.take(one)
    return course.finding()


@dataclass(slots=True, eq=False)
class _Sum:
    """A triangular root of what is accumulated, and its squared error by columns."""

    root: Array
    squared: Array

    def add(self, root: Array, squared: Array) -> None:
        self.squared = self.squared + squared + squared_rounding(len(root)) * (root**2).sum(axis=0)
        self.root = np.asarray(np.linalg.qr(np.vstack([self.root, root]), mode="r"), dtype=float)


class _Course:
    """What is carried from segment to segment."""

    def __init__(self, moving: Array, units: Array, forms: Array) -> None:
        n = len(units)
        self.moving, self.units, self.forms = moving, units, forms
        self.parts: list[tuple[_Numbers, ...]] = []
        self.total, self.stripped = (_Sum(np.zeros((n, n)), np.zeros(n)) for _ in range(2))
        self.transition, self.moved = np.eye(n), np.zeros((n, n))
        self.since = np.full(len(forms), np.nan)
        self.decided = True
        self.last: tuple[Subspaces, Subspaces] | None = None

    def take(self, some: Segments) -> None:
        """Add segments."""
        stops = some.starts + some.durations
        gramian = some.stack.triangle(some.starts, stops, np.ones(len(self.units)))
        local = subspaces(gramian.in_units(np.broadcast_to(self.units, gramian.units.shape)))
        residual, known = _condition(local, some, self.moving, self.units)
        total, stripped = self._accumulated(gramian, some)
        self.last = total.only(-1 % len(stops)), stripped.only(-1 % len(stops))
        self._note(total, stops)
        self.decided &= bool((local.decided & total.decided & stripped.decided).all())
        self.parts.append((some.starts, stops, local.rank, residual, known, total.rank, stripped.rank))

    def _accumulated(self, local: Gramian, some: Segments) -> tuple[Subspaces, Subspaces]:
        phi = some.transition
        if phi is None:
            phi = exponentials(some.A, self.moving, some.durations)
        kept: tuple[list[_Sum], list[_Sum]] = ([], [])
        for j, root in enumerate(local.matrices):
            squared = np.diag(local.error[j])
            known = squared @ self.transition**2 + ((np.abs(root) @ self.moved) ** 2).sum(axis=0)
            self.total.add(root @ self.transition, known)
            self.stripped.add(root, squared)
            for one, into in zip((self.total, self.stripped), kept, strict=True):
                into.append(_Sum(one.root, one.squared))
            self._move(phi[j])
        total, stripped = (self._decomposed(one, local) for one in kept)
        return total, stripped

    def _move(self, rows: Array) -> None:
        step = np.eye(len(self.units))
        step[self.moving] = rows
        off = _EXPONENTIAL * EPS * np.abs(step)
        self.moved = np.abs(step) @ self.moved + off @ np.abs(self.transition)
        self.transition = step @ self.transition

    def _decomposed(self, sums: list[_Sum], like: Gramian) -> Subspaces:
        root, squared = np.array([one.root for one in sums]), np.array([one.squared for one in sums])
        error = squared[:, :, None] * np.eye(len(self.units))
        found = Gramian(
            "square-root", like.instants, like.starts, root, np.ones_like(squared), error, like.growth
        )
        return subspaces(found.in_units(np.broadcast_to(self.units, squared.shape)))

    def _note(self, total: Subspaces, stops: Array) -> None:
        """Keep the first instant at which each linear form is identifiable."""
        unit = self.forms * self.units
        unit = unit / np.linalg.norm(unit, axis=1, keepdims=True)
        seen = identifiable(total, unit @ np.swapaxes(total.right, 1, 2)) & total.decided[:, None]
        for q in np.flatnonzero(np.isnan(self.since) & seen.any(axis=0)):
            self.since[q] = stops[seen[:, q].argmax()]

    def finding(self) -> PiecewiseConstant:
        assert self.last is not None
        starts, stops, rank, residual, known, total, stripped = (
            np.concatenate(column) for column in zip(*self.parts, strict=True)
        )
        of_total, of_stripped = (one.values[0] for one in self.last)
        return PiecewiseConstant(
            starts=starts,
            stops=stops,
            local_rank=rank,
            residual=residual,
            known=known,
            total_rank=total,
            stripped_rank=stripped,
            total_values=of_total,
            stripped_values=of_stripped,
            since=self.since,
            decided=self.decided,
        )


def _condition(local: Subspaces, some: Segments, moving: Array, units: Array) -> tuple[Array, Array]:
    """Return ‖D⁻¹ A D N‖ of every segment, and what it may be by what N is known to; shape (k,) each."""
    scale = units / units[moving][:, None]
    A, A_error = some.A * scale, some.A_error * scale
    hidden = np.arange(local.n) >= local.rank[:, None]
    N = np.swapaxes(local.right, 1, 2) * hidden[:, None, :]
    residual = np.linalg.norm(A @ N, ord=2, axis=(1, 2))
    size = np.linalg.norm(A, axis=(1, 2))
    known = size * (local.kernel_angle + TOLERANCE * EPS) + TOLERANCE * np.linalg.norm(A_error, axis=(1, 2))
    return residual, known
