"""Transition matrices on panels, all panels at once, by collocation of high order with error control.

On a panel [a, b], h = b − a, the transition X(τ) = Φ(τ, b) satisfies X' = A X, X(b) = I, hence

    X(τ) = I − ∫_τ^b A X,    X_j ← I − h Σ_l B_jl A(τ_l) X_l    (repeated until it stands)

at the Gauss–Legendre nodes τ_j, which gives Φ(a, b) and the rows H(τ_j) Φ(τ_j, b) of the Gramian together.
Only the moving states' rows of X differ from those of I. Panels start no longer than the dynamics and the
coefficients allow; one whose A X is not resolved (the estimate of its next Legendre coefficient, relative to
the entry, exceeds rtol) is halved. Of a time-invariant system panels of the same length are solved once, so
also the halves of a panel.

References
----------
E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, II.1 (collocation methods).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from obscli.numeric.collocation import gauss_legendre
from obscli.numeric.errors import NotComputableError, TooManyStepsError
from obscli.numeric.knots import with_knots
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.panels import Panels, Solved, beside, merged, repeated
from obscli.numeric.program import EPS, ROUNDING, Array, Counts, Flags
from obscli.numeric.rates import Rates
from obscli.numeric.settings import Effort


NODES: Final = 16

#: Nodes of panels between samples of signals, which are short.
FEW_NODES: Final = 10

#: At how many nodes rounding errors of the coefficients are looked at: the largest counts for the panel.
_PROBED: Final = 4

#: A panel starts at most so long in units of 1/λ (the iteration converges like (hλ)^k/k!) and of 1/ν.
_MOST_TURN: Final = 2.0
_MOST_PHASE: Final = 1.5
_SWEEPS: Final = 60

#: Where the largest entries are far from rest after so many sweeps, panels are too long.
_ENOUGH: Final = 24
_FAR: Final = 1e-3
_FEW: Final = 12
_TERMS: Final = 12

#: A tail is rounding below so many times what A X may be off by. One below this that halving does not lower
#: is left at once, one above it after so many halvings; a panel shorter than this, relative to the time,
#: cannot be halved.
_NOISY: Final = 8.0
_NOISE: Final = 1e-9
_IN_VAIN: Final = 3

#: A tail above this that halving does not lower is a pole.
_POLE: Final = 1e-2
_SHORTEST: Final = 1e-12

#: Panels of a time-invariant system are alike if their lengths agree to so many digits.
_ALIKE: Final = 10

#: Numbers (of 8 bytes) worked on at a time.
_CHUNK: Final = 4_000_000


def longest_step(rates: Rates) -> float:
    """Return the longest panel that rates allow."""
    turn = _MOST_TURN / rates.dynamics if rates.dynamics else np.inf
    return min(turn, _MOST_PHASE / rates.coefficients if rates.coefficients else np.inf)


def edges_of(start: float, instants: Array, longest: float, most: int) -> Array:
    """Return the edges of panels no longer than ``longest``, one at every instant.

    Raises
    ------
    TooManyStepsError
        where they would be more than ``most``, or shorter than time can be told
    """
    edges = np.concatenate([[start], instants])
    with np.errstate(divide="ignore", over="ignore"):
        counts = np.maximum(np.ceil(np.diff(edges) / longest * (1 - 1e-12)), 1)
    finest = np.spacing(np.abs(edges).max())
    if not (counts.sum() <= most and (np.diff(edges) > 2 * counts * finest).all()):
        raise TooManyStepsError(_too_many(most))
    each = counts.astype(int)
    within = np.arange(each.sum()) - np.repeat(each.cumsum() - each, each)
    return np.append(np.repeat(edges[:-1], each) + within * np.repeat(np.diff(edges) / each, each), edges[-1])


def panels(system: NumericSystem, edges: Array, effort: Effort) -> Iterator[Panels]:
    """Yield the panels between edges in order, in pieces that fit into memory.

    Samples of signals are edges too: between them coefficients are smooth. They do not count as steps.

    Raises
    ------
    NotComputableError
        where a panel cannot be resolved however short it is, or a coefficient does not exist; for a
        discrete-time system
    """
    require_derivative(system)
    size = NODES * system.n * (len(system.moving) + system.m)
    coarse = edges
    edges, inserted = with_knots(edges, system.knots(float(edges[0]), float(edges[-1])))
    effort = replace(effort, most_steps=effort.most_steps + 2 * inserted)
    nodes = FEW_NODES if 2 * inserted > len(edges) else NODES
    size = nodes * system.n * (len(system.moving) + system.m)
    at_once = max(_CHUNK // max(size, 1), 1)
    solver = _Solver(system, effort, nodes)
    for first in range(0, len(edges) - 1, at_once):
        part = edges[first : first + at_once + 1]
        whole = np.searchsorted(coarse, part[:-1], side="right") if inserted else None
        yield solver.resolved(part[:-1], part[1:], whole=whole)


def require_derivative(system: NumericSystem) -> None:
    """Refuse to integrate a discrete-time system, whoever asks: its A is F, and gives no derivative.

    Raises
    ------
    NotComputableError
        where the system is one
    """
    if system.system.discrete:
        raise NotComputableError(
            "this is computed for continuous time; a discrete-time model is not taken yet"
        )


@dataclass(frozen=True, slots=True, eq=False)
class Parents:
    """Of the panels that some are halves of: how far from being resolved, (k,), the size of A X, (k, p, n).

    ``in_vain``: how many halvings in a row did not improve them, shape (k,).
    An entry that passes through zero inside a short panel is held to its size on the panel it began with, and
    so is one between samples of signals.
    """

    unresolved: Array
    largest: Array
    in_vain: Counts

    def of_halves(self) -> Parents:
        """Return what is known of the parents of all first halves, then of all second halves."""
        return Parents(
            np.tile(self.unresolved, 2), np.tile(self.largest, (2, 1, 1)), np.tile(self.in_vain, 2)
        )


def _too_many(most: int) -> str:
    return f"more than {most} steps would be needed: choose a shorter interval (--from, --to)"


def not_resolved(system: NumericSystem, t: float) -> str:
    """Return the message where the coefficients have a pole, or are as good as random."""
    return (
        f"the coefficients cannot be resolved near {system.system.time} = {t:.6g}, however short "
        "the steps: choose instants that leave it out (--from, --to)"
    )


class _Solver:
    """Solves panels of one system."""

    def __init__(self, system: NumericSystem, effort: Effort, nodes: int) -> None:
        self._system = system
        self._effort = effort
        self._rule = gauss_legendre(nodes)
        self._probed = np.linspace(0, nodes - 1, _PROBED).round().astype(int)
        self._solved = 0

    def resolved(
        self, starts: Array, stops: Array, parents: Parents | None = None, whole: Counts | None = None
    ) -> Panels:
        """Return the panels, those that are not resolved halved until they are.

        Parameters
        ----------
        parents : what is known of the panels that these are halves of
        whole : numbers, in order, of the panels that these are parts of between samples of signals, (k,)
        """
        self._count(len(starts))
        if parents is None and self._system.is_constant and len(starts) > 1:
            return self._alike(starts, stops)
        with np.errstate(over="ignore", invalid="ignore"):  # not finite: does not stand
            found, tail, largest = beside([self._solve(one, starts, stops) for one in self._system.parts])
        if parents is not None:
            largest = np.maximum(largest, parents.largest)
        if whole is not None:
            _, first, which = np.unique(whole, return_index=True, return_inverse=True)
            largest = np.maximum.reduceat(largest, first, axis=0)[which]
        unresolved = (tail / np.maximum(largest, 1e-300)).max(axis=(1, 2), initial=0.0)
        bad = unresolved > self._effort.rtol
        in_vain = np.zeros(len(starts), dtype=int)
        if parents is not None:
            # what halving does not improve is rounding of the coefficients, or an entry too small to matter
            # (h^k/k! far down a chain of integrators): it is left, and stays in the step error
            in_vain = np.where(unresolved > parents.unresolved / 4, parents.in_vain + 1, 0)
            left = np.where(unresolved < _NOISE, 1, np.where(unresolved < _POLE, _IN_VAIN, np.inf))
            bad &= np.isinf(unresolved) | (in_vain < left)
        if not bad.any():
            return found
        if (stops - starts)[bad].min() < _SHORTEST * np.abs(stops).max():
            raise NotComputableError(not_resolved(self._system, float(starts[bad][0])))
        fine = self._halved(starts[bad], stops[bad], Parents(unresolved[bad], largest[bad], in_vain[bad]))
        return merged(found, ~bad, fine)

    def _halved(self, starts: Array, stops: Array, parents: Parents) -> Panels:
        """Return the halves of panels, resolved; where nothing varies both are alike, one is solved."""
        middles = (starts + stops) / 2
        if self._system.is_constant and len(starts) == 1:
            first = self.resolved(starts, middles, parents)
            self._count(len(first.ends))
            return repeated(first, stops)
        return self.resolved(
            np.concatenate([starts, middles]), np.concatenate([middles, stops]), parents.of_halves()
        )

    def _count(self, steps: int) -> None:
        self._solved += steps
        if self._solved > self._effort.most_steps:
            raise TooManyStepsError(_too_many(self._effort.most_steps))

    def _alike(self, starts: Array, stops: Array) -> Panels:
        """Return the panels of a time-invariant system, those of the same length solved once."""
        h = stops - starts
        _, first, which = np.unique(np.round(h / h.max(), _ALIKE), return_index=True, return_inverse=True)
        solved = [self.resolved(starts[k : k + 1], stops[k : k + 1]) for k in first]
        order = np.concatenate([np.arange(len(solved[k].ends)) for k in which])
        of = np.repeat(which, [len(solved[k].ends) for k in which])

        def spread(part: Callable[[Panels], Array]) -> Array:
            return np.array([part(solved[k])[i] for k, i in zip(of, order, strict=True)])

        # a panel that had to be halved comes in parts, whose ends lie as far after the start
        ends = np.concatenate([stops[j] - (solved[k].ends[-1] - solved[k].ends) for j, k in enumerate(which)])
        return Panels(
            ends,
            spread(lambda p: p.transition),
            spread(lambda p: p.rows),
            spread(lambda p: p.transition_error),
            spread(lambda p: p.row_error),
        )

    def _solve(self, system: NumericSystem, starts: Array, stops: Array) -> Solved:
        """Return the panels, the tail of A X (0: noise, infinite: X does not stand), and the size of A X."""
        rule, nodes = self._rule, len(self._rule.nodes)
        moving, n = system.moving, system.n
        h = stops - starts
        t = starts[:, None] + h[:, None] * rule.nodes
        A, H = (one.reshape(len(h), nodes, -1, n) for one in system.matrices(t.ravel()))
        errors = system.coefficients(t[:, self._probed].ravel())
        A_error = errors.A_error.reshape(len(h), _PROBED, -1, n).max(axis=1)
        H_error = errors.H_error.reshape(len(h), _PROBED, -1, n).max(axis=1)
        base = np.eye(n)[moving] - summed(rule.backward, h[:, None, None, None] * without(A, moving))
        X, derivative, stands = self._iterate(A[..., moving], without(A, moving), base, h)
        largest = np.where(stands[:, None, None], np.abs(derivative).max(axis=1), 0.0)
        tail = np.where(stands[:, None, None], _tail(derivative, rule.spectrum), np.inf)
        size, largest_X = np.abs(A).max(axis=1), np.abs(X).max(axis=1)
        noise = _rounding(size, EPS * size + A_error, moving, h)
        step = h[:, None, None]

        def over_panel(error: Array) -> Array:
            local = times(error, largest_X, moving)
            squared: Array = (step * (local + step / 2 * (size[..., moving] @ local))) ** 2
            return squared

        # sums round at random from node to node; so do coefficients where they vary
        drift = over_panel(2 * ROUNDING * size) / nodes
        drift += over_panel(A_error) / (1 if system.is_constant else nodes)
        whole = step * summed(rule.weights[None], derivative)[:, 0]
        in_rows = times(H_error**2, largest_X**2, moving)
        in_rows += (H**2).max(axis=1)[..., moving] @ drift
        shares = np.sqrt(h[:, None] * rule.weights)[..., None, None]
        found = Panels(
            ends=stops,
            transition=np.eye(n)[moving] - whole,
            rows=(shares * times(H, X, moving)).reshape(len(h), nodes * system.m, n),
            transition_error=(step * tail / nodes) ** 2 + drift,
            row_error=h[:, None] * in_rows.sum(axis=1),
        )
        return found, np.where(stands[:, None, None] & (tail <= _NOISY * noise), 0.0, tail), largest

    def _iterate(self, inner: Array, outer: Array, base: Array, h: Array) -> tuple[Array, Array, Flags]:
        """Iterate X ← I − h B (A X), all panels together.

        Parameters
        ----------
        inner, outer : the moving columns of A (k, s, p, p); A with zeros there (k, s, p, n)
        base : I − h B (A X) without the moving columns, shape (k, s, p, n)

        Returns
        -------
        X : the moving rows at the nodes, shape (k, s, p, n)
        derivative : A X, shape (k, s, p, n)
        stands : for which panels the iteration has come to rest, shape (k,)
        """
        step = h[:, None, None, None]
        inner, X = step * inner, base
        inner_size, outer_size = np.abs(inner).max(axis=1), h[:, None, None] * np.abs(outer).max(axis=1)
        first = _sweeps_needed(float(inner_size.sum(axis=2).max(initial=0.0)))
        stands = np.zeros(len(h), dtype=bool)
        for sweep in range(_SWEEPS):
            before, X = X, base - summed(self._rule.backward, inner @ X)
            if sweep < first:
                continue
            largest = np.abs(X).max(axis=1)
            rounding = 2 * EPS * (largest + inner_size @ largest + outer_size)
            if not np.isfinite(rounding).all():
                break
            change = np.abs(X - before).max(axis=1)
            stands = (change <= rounding).all(axis=(1, 2))
            if stands.all() or (sweep == _ENOUGH and change.max() > _FAR * largest.max()):
                break
        return X, (inner @ X) / step + outer, stands


def _sweeps_needed(x: float) -> int:
    """Return after how many sweeps to look: the k-th changes X by x^k/k! at the most; few for a large x."""
    change, k = 1.0, 0
    while change > EPS and k < _FEW:
        k += 1
        change *= x / k
    return k


def _rounding(A: Array, error: Array, moving: Array, h: Array) -> Array:
    """Return what A X may be off by, e^(h|A|) ΔA e^(h|A|), shape (k, p, n).

    Where A X is zero by cancellation, its rounding is relative to what it is summed from.
    """
    largest = np.eye(A.shape[2])[moving] + _grown(A, h[:, None, None] * A, moving, h, first=2)
    return _grown(A, times(error, largest, moving), moving, h, first=1)


def _grown(A: Array, term: Array, moving: Array, h: Array, first: int) -> Array:
    """Return the sum of terms, each h A/k times the one before, k counted from ``first``."""
    total = term
    for k in range(first, first + _TERMS):
        term = h[:, None, None] / k * (A[..., moving] @ term)
        total = total + term
    return total


def times(rows: Array, X: Array, moving: Array) -> Array:
    """Return rows X, given only the moving rows of X; the others are those of I."""
    return rows[..., moving] @ X + without(rows, moving)


def without(matrix: Array, columns: Array) -> Array:
    """Return a matrix with zeros in some columns."""
    rest = matrix.copy()
    rest[..., columns] = 0
    return rest


def summed(weights: Array, at_nodes: Array) -> Array:
    """Return Σ_l weights_jl g(τ_l): (r, s) with (k, s, p, n) gives (k, r, p, n)."""
    k, s, p, n = at_nodes.shape
    return (weights @ at_nodes.reshape(k, s, p * n)).reshape(k, len(weights), p, n)


def _tail(derivative: Array, spectrum: Array) -> Array:
    """Return an estimate of the first Legendre coefficient of A X that is left out, (k, p, n)."""
    last = np.abs(summed(spectrum[-4:], derivative))
    fore, after = last[:, :2].max(axis=1), last[:, 2:].max(axis=1)
    tail: Array = after * np.minimum(after / np.maximum(fore, 1e-300), 1.0)
    return tail
