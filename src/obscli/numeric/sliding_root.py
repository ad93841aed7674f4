"""Square roots of the Gramian over many overlapping windows, every panel solved once, O(1) QR a window.

Over a panel [e_k, e_k+1] with root R_k and transition Φ_k, over [a, c] and [c, b]:

    W(b, a) = Rᵀ R,    R = qr [R_ac Φ(c, b); R_cb],    Φ(a, b) = Φ(a, c) Φ(c, b)

is associative, so a window [a, b] is the end of a stretch before a point c and the beginning of one after it
(``stretches``). All ends of [·, c] are found going back from c, all beginnings of [c, ·] going on from it,
all points side by side.

The error, |ΔR v|² ≲ vᵀ E v, obeys the law of ``square_root``: a panel adds rounding, step and coefficients
relative to the columns of what the window has gathered up to there, diag(d_k), carried on as Φᵀ E Φ. These
columns are taken from the earliest window at the point that holds the panel, whose information is the
largest. Products Φ(c, b) formed by themselves are rounded relative to their entries, which adds diag(E) where
they are used.

References
----------
K. Tangwongsan, M. Hirzel, S. Schneider (2017), Low-latency sliding-window aggregation in worst-case constant
time (the queue of two stacks).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from obscli.numeric.gramian import LOST, Gramian, squared_rounding
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import EPS, Array, Counts
from obscli.numeric.settings import Effort
from obscli.numeric.stretches import Stretches, stretches
from obscli.numeric.transition import panels


@dataclass(frozen=True, slots=True, eq=False)
class Blocks:
    """What is known of B panels; everything is referred to their ends.

    ``edges`` (B + 1,); ``roots`` R_k (B, r, n); ``transition`` Φ_k (B, n, n); ``moving``: rows of Φ that are
    not those of I; ``transition_error``: squared error of these rows, (B, p, n); ``own_error``: d_k of the
    panel's own rows, (B, n); ``rounding``: ε² of one factorisation or product.
    """

    edges: Array
    roots: Array
    transition: Array
    moving: Counts
    transition_error: Array
    own_error: Array
    rounding: float

    @property
    def n(self) -> int:
        """The number of states."""
        return int(self.transition.shape[-1])

    def carrying(self, k: Counts, before: Array, moved: Array, held: Counts) -> Array:
        """Return d_k of what is carried over panels k, (K, n), after ``held`` panels that erred partly alike.

        Parameters
        ----------
        before, moved : squared norms of the columns at the start and at the end of the panels, (K, n)
        """
        alike = held[:, None] / 9
        step = np.einsum("ki,kij->kj", before[:, self.moving], self.transition_error[k])
        carried: Array = self.rounding * (1 + 2 * alike + 1 / 9) * moved + (1 + 2 * alike) * step
        return carried


def sliding_gramians(
    system: NumericSystem, edges: Array, windows: tuple[Array, Array], reach: float, effort: Effort
) -> Gramian:
    """Return R(t_i) for W(t_i, s_i) of all windows; R = 0 with error ``LOST`` where columns grow too far.

    Parameters
    ----------
    edges : of the panels, among them all s_i and t_i, shape (B + 1,)
    windows : s_i and t_i > s_i, neither ever decreasing, shape (N,) each
    reach : how long a window may start before the point it is put together at: where modes decay, the shared
        bound is wider than that of a window alone by their growth backwards over that time
    effort : step error allowed, relative to each entry of A Φ, and how many steps

    Raises
    ------
    NotComputableError
        where the coefficients cannot be resolved, or do not exist at some instant
    """
    with np.errstate(all="ignore"):  # where squares are too large all is lost
        blocks = _blocks(system, edges, effort)
        a, b = (np.searchsorted(blocks.edges, one) for one in windows)
        farthest = np.searchsorted(blocks.edges, blocks.edges[a] + reach, side="right") - 1
        roots, error = _put_together(blocks, stretches(a, b, np.maximum(farthest, a + 1)))
    lost = ~(np.isfinite(error).all(axis=(1, 2)) & np.isfinite(roots).all(axis=(1, 2)))
    roots[lost], error[lost] = 0.0, LOST * np.eye(system.n)
    starts, stops = windows
    units, growth = np.ones((len(stops), system.n)), np.zeros(len(stops))
    return Gramian("square-root", stops, starts, roots, units, error, growth)


def _blocks(system: NumericSystem, edges: Array, effort: Effort) -> Blocks:
    n, moving, rounding = system.n, system.moving, squared_rounding(system.n)
    parts = list(panels(system, edges, effort))
    ends = np.concatenate([one.ends for one in parts])
    transition = np.tile(np.eye(n), (len(ends), 1, 1))
    transition[:, moving] = np.concatenate([one.transition for one in parts])
    squares = np.concatenate([_squares(one.rows) for one in parts])
    return Blocks(
        edges=np.concatenate([edges[:1], ends]),
        roots=np.concatenate([_triangle(one.rows) for one in parts]),
        transition=transition,
        moving=moving,
        transition_error=np.concatenate([one.transition_error for one in parts]),
        own_error=1.25 * rounding * squares + np.concatenate([one.row_error for one in parts]),
        rounding=rounding,
    )


def _put_together(blocks: Blocks, which: Stretches) -> tuple[Array, Array]:
    """Return R and E of all windows, shape (N, n, n) each."""
    ends, ends_error = _ends(blocks, which)
    begun, carry, begun_error, at = _beginnings(blocks, which, ends)
    S, P = ends[which.a], carry[at]
    roots = _triangle(np.concatenate([S @ P, begun[at]], axis=1))
    error = _congruent(ends_error[which.a], P) + begun_error[at]
    product = np.einsum("ki,kij->kj", _squares(S), P**2)
    _diagonal(error)[...] += blocks.rounding * (product + _squares(roots))
    return roots, error


def _ends(blocks: Blocks, which: Stretches) -> tuple[Array, Array]:
    """Return R and E of [e_j, c] at c, by j, going back from every c; shape (B, n, n) each."""
    n, starts, points = blocks.n, which.starts, which.points
    roots, after = np.zeros((2, len(blocks.roots), n, n))
    R, T = np.zeros((len(points), n, n)), np.tile(np.eye(n), (len(points), 1, 1))
    for step in range(int((points - starts).max())):
        g = np.flatnonzero(points - starts > step)
        j = points[g] - 1 - step
        after[j] = T[g]
        roots[j] = R[g] = _triangle(np.concatenate([blocks.roots[j] @ T[g], R[g]], axis=1))
        T[g] = blocks.transition[j] @ T[g]
    made = after.swapaxes(1, 2) @ (_gathering(blocks, starts, points)[:, :, None] * after)
    diagonal = _diagonal(made)
    diagonal += diagonal + blocks.rounding * _squares(roots)
    for a, c in zip(starts.tolist(), points.tolist(), strict=True):
        made[a:c] = made[a:c][::-1].cumsum(axis=0)[::-1]
    return roots, made


def _gathering(blocks: Blocks, starts: Counts, points: Counts) -> Array:
    """Return d_k of panels before each point, gathered from the earliest start on, shape (B, n)."""
    before, moved = np.zeros((2, len(blocks.roots), blocks.n))
    held = np.zeros(len(blocks.roots), dtype=int)
    fresh = blocks.roots.swapaxes(1, 2) @ blocks.roots
    W = np.zeros((len(points), blocks.n, blocks.n))
    for step in range(int((points - starts).max())):
        g = np.flatnonzero(points - starts > step)
        k = starts[g] + step
        before[k], held[k] = _diagonal(W[g]), step
        W[g] = _congruent(W[g], blocks.transition[k])
        moved[k] = _diagonal(W[g])
        W[g] += fresh[k]
    # the diagonal of a product of three is known to rounding of what it is summed from
    least = blocks.n * EPS * np.einsum("ki,kij->kj", before, blocks.transition**2)
    every = np.arange(len(held))
    return blocks.own_error + blocks.carrying(every, before, np.maximum(moved, least), held)


def _beginnings(blocks: Blocks, which: Stretches, ends: Array) -> tuple[Array, Array, Array, Counts]:
    """Return R, Φ and E of [c, e] at e, going on from every c to one edge e after the other, shape (L, n, n).

    E is that of all that is carried from c on, the ends of windows included. The last of each is that of
    [c, c]. Also returned: which of them each window takes, shape (N,).
    """
    n, points, lengths = blocks.n, which.points, which.stops - which.points
    offset = lengths.cumsum() - lengths
    total = int(lengths.sum())
    roots, carry, error = np.zeros((3, total + 1, n, n))
    carry[...] = np.eye(n)
    before, moved = np.zeros((2, total, n))
    R, E = np.zeros((2, len(points), n, n))
    P = np.tile(np.eye(n), (len(points), 1, 1))
    for step in range(int(lengths.max())):
        g = np.flatnonzero(lengths > step)
        k, at = points[g] + step, offset[g] + step
        before[at] = _squares(R[g])
        R_moved, P[g] = R[g] @ blocks.transition[k], P[g] @ blocks.transition[k]
        moved[at] = _squares(R_moved)
        roots[at] = R[g] = _triangle(np.concatenate([R_moved, blocks.roots[k]], axis=1))
        carry[at] = P[g]
    d = _going_on(blocks, which, ends, carry, before, moved) + blocks.rounding * _squares(roots[:-1])
    for step in range(int(lengths.max())):
        g = np.flatnonzero(lengths > step)
        at = offset[g] + step
        E[g] = _congruent(E[g], blocks.transition[points[g] + step])
        _diagonal(E)[g] += d[at]
        error[at] = E[g]
    after = which.b - points[which.group]
    return roots, carry, error, np.where(after > 0, offset[which.group] + after - 1, total)


def _going_on(
    blocks: Blocks, which: Stretches, ends: Array, carry: Array, before: Array, moved: Array
) -> Array:
    """Return d_k of panels after each point, the end of the earliest window carried beside, shape (L − 1, n).

    Parameters
    ----------
    before, moved : squared norms of the columns of what began at the point, (L − 1, n)
    """
    lengths = which.stops - which.points
    at, group = np.arange(lengths.sum()), np.repeat(np.arange(len(lengths)), lengths)
    step = at - np.repeat(lengths.cumsum() - lengths, lengths)
    k = which.points[group] + step
    # among the windows of a point, the first that holds the panel
    earliest = which.a[np.maximum(np.searchsorted(which.b, k, side="right"), which.first[group])]
    S = ends[earliest]
    before = before + _carried(S, carry[np.where(step > 0, at - 1, len(at))])
    moved = moved + _carried(S, carry[:-1])
    d: Array = blocks.own_error[k] + blocks.carrying(k, before, moved, k - earliest)
    return d


def _carried(S: Array, P: Array) -> Array:
    """Return the squared norms of the columns of S P, and of what they are summed from, added, (K, n)."""
    summed: Array = np.einsum("ki,kij->kj", _squares(S), P**2)
    return summed + _squares(S @ P)


def _triangle(rows: Array) -> Array:
    """Return R of each, shape (K, min(r, n), n)."""
    triangle: Array = np.linalg.qr(rows, mode="r")  # type: ignore[assignment]  # no QRResult in this mode
    return triangle


def _squares(rows: Array) -> Array:
    """Return the squared norms of the columns of (K, r, n), shape (K, n)."""
    found: Array = np.einsum("kij,kij->kj", rows, rows)
    return found


def _congruent(E: Array, T: Array) -> Array:
    """Return Tᵀ E T."""
    return T.swapaxes(1, 2) @ E @ T


def _diagonal(E: Array) -> Array:
    """Return the diagonals of (K, n, n) as a view, shape (K, n)."""
    view: Array = np.einsum("kjj->kj", E)
    return view
