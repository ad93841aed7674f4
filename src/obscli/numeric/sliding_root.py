"""Square roots of the Gramian over many overlapping windows, every panel solved once, O(1) QR a window.

Over a panel [e_k, e_k+1] with root R_k and transition Φ_k, over [a, c] and [c, b]:

    W(b, a) = Rᵀ R,    R = qr [R_ac Φ(c, b); R_cb],    Φ(a, b) = Φ(a, c) Φ(c, b)

is associative, so a window [a, b] is the end of a stretch before a point c and the beginning of one after
it. Windows in order share c until one starts behind it (the queue of two stacks): all ends of [·, c] are
found going back from c, all beginnings of [c, ·] going on from it, each panel once, all c side by side.

The error, |ΔR v|² ≲ vᵀ E v, obeys the law of ``square_root``: a panel adds rounding, step and coefficients
relative to the columns of what the window has gathered up to there, diag(d_k), carried on as Φᵀ E Φ. These
columns are taken from the earliest window that holds the panel, whose information is the largest. Products
Φ(c, b) formed by themselves are rounded relative to their entries, which adds diag(E) where they are used.

References
----------
K. Tangwongsan, M. Hirzel, S. Schneider (2017), Low-latency sliding-window aggregation in worst-case constant
time, 2 (queue of two stacks).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from obscli.numeric.gramian import LOST, Gramian, squared_rounding
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import EPS, Array, Counts
from obscli.numeric.settings import Effort
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

    def carrying(self, before: Array, moved: Array, held: Counts) -> Array:
        """Return d_k of what is carried over every panel after ``held`` that erred partly alike, (B, n).

        Parameters
        ----------
        before, moved : squared norms of the columns at the start and at the end of the panels, (B, n)
        """
        alike = held[:, None] / 9
        step = np.einsum("ki,kij->kj", before[:, self.moving], self.transition_error)
        carried: Array = self.rounding * (1 + 2 * alike + 1 / 9) * moved + (1 + 2 * alike) * step
        return carried


@dataclass(frozen=True, slots=True, eq=False)
class Stretches:
    """Windows [a_i, b_i] as numbers of edges in order, and the point c_i that each is put together at.

    All of shape (N,); ``first``, ``last``: the first and the last window at each of the G points, shape (G,).
    """

    a: Counts
    b: Counts
    c: Counts
    first: Counts
    last: Counts


def stretches(a: Counts, b: Counts) -> Stretches:
    """Return the points at which windows are put together: the end of the first that starts behind the last.

    Parameters
    ----------
    a, b : edges of the windows, a < b, neither ever decreasing, shape (N,)
    """
    c = np.empty_like(b)
    point = -1
    for i, (start, stop) in enumerate(zip(a.tolist(), b.tolist(), strict=True)):
        if start >= point:
            point = stop
        c[i] = point
    _, first = np.unique(c, return_index=True)
    return Stretches(a, b, c, first, np.append(first[1:], len(c)) - 1)


def sliding_gramians(
    system: NumericSystem, edges: Array, starts: Array, stops: Array, effort: Effort
) -> Gramian:
    """Return R(t_i) for W(t_i, s_i) of all windows; R = 0 with error ``LOST`` where columns grow too far.

    Parameters
    ----------
    edges : of the panels, among them all s_i and t_i, shape (B + 1,)
    starts, stops : s_i < t_i, neither ever decreasing, shape (N,)
    effort : step error allowed, relative to each entry of A Φ, and how many steps

    Raises
    ------
    NotComputableError
        where the coefficients cannot be resolved, or do not exist at some instant
    """
    with np.errstate(all="ignore"):  # where squares are too large all is lost
        blocks = _blocks(system, edges, effort)
        which = stretches(np.searchsorted(blocks.edges, starts), np.searchsorted(blocks.edges, stops))
        roots, error = _put_together(blocks, which)
    lost = ~(np.isfinite(error).all(axis=(1, 2)) & np.isfinite(roots).all(axis=(1, 2)))
    roots[lost], error[lost] = 0.0, LOST * np.eye(system.n)
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
    begun, carry, begun_error = _beginnings(blocks, which, ends)
    b = np.where(which.b > which.c, which.b, 0)  # nothing begins at edge 0
    S, P = ends[which.a], carry[b]
    roots = _triangle(np.concatenate([S @ P, begun[b]], axis=1))
    error = _congruent(ends_error[which.a], P) + begun_error[b]
    product = np.einsum("ki,kij->kj", _squares(S), P**2)
    _diagonal(error)[...] += blocks.rounding * (product + _squares(roots))
    return roots, error


def _ends(blocks: Blocks, which: Stretches) -> tuple[Array, Array]:
    """Return R and E of [e_j, c] at c, by j, going back from every c; shape (B, n, n) each."""
    n, starts, points = blocks.n, which.a[which.first], which.c[which.first]
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
    return blocks.own_error + blocks.carrying(before, np.maximum(moved, least), held)


def _beginnings(blocks: Blocks, which: Stretches, ends: Array) -> tuple[Array, Array, Array]:
    """Return R, Φ and E of [c, e_k] at e_k, by k, going on from every c; shape (B + 1, n, n) each.

    E is that of all that is carried from c on, the ends of windows included.
    """
    n, points, stops = blocks.n, which.c[which.first], which.b[which.last]
    roots, carry, error = np.zeros((3, len(blocks.edges), n, n))
    carry[...] = np.eye(n)
    R, E = np.zeros((2, len(points), n, n))
    P = np.tile(np.eye(n), (len(points), 1, 1))
    before, moved = np.zeros((2, len(blocks.roots), n))
    for step in range(int((stops - points).max())):
        g = np.flatnonzero(stops - points > step)
        k = points[g] + step
        before[k] = _squares(R[g])
        R_moved, P[g] = R[g] @ blocks.transition[k], P[g] @ blocks.transition[k]
        moved[k] = _squares(R_moved)
        roots[k + 1] = R[g] = _triangle(np.concatenate([R_moved, blocks.roots[k]], axis=1))
        carry[k + 1] = P[g]
    d = _going_on(blocks, which, ends, carry, before, moved) + blocks.rounding * _squares(roots[1:])
    for step in range(int((stops - points).max())):
        g = np.flatnonzero(stops - points > step)
        k = points[g] + step
        E[g] = _congruent(E[g], blocks.transition[k])
        _diagonal(E)[g] += d[k]
        error[k + 1] = E[g]
    return roots, carry, error


def _going_on(
    blocks: Blocks, which: Stretches, ends: Array, carry: Array, before: Array, moved: Array
) -> Array:
    """Return d_k of panels after each point, the end of the earliest window carried beside, shape (B, n).

    Parameters
    ----------
    before, moved : squared norms of the columns of what began at the point, (B, n)
    """
    k = np.arange(len(blocks.roots))
    earliest = which.a[np.minimum(np.searchsorted(which.b, k, side="right"), len(which.b) - 1)]
    points = which.c[which.first]
    start = np.where(np.isin(k, points), 0, k)  # nothing has begun at a point
    S = ends[earliest]
    before, moved = before + _carried(S, carry[start]), moved + _carried(S, carry[k + 1])
    return blocks.own_error + blocks.carrying(before, moved, np.maximum(k - earliest, 0))


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
