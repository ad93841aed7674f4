"""Transition matrices from the start of a panel to any instant within it, as polynomials in time.

On a panel [a, b], h = b − a, u = (τ − a)/h, the transition Y(τ) = Φ(τ, a) satisfies Y' = A Y, Y(a) = I:

    Y_j ← I + h Σ_l F_jl A(τ_l) Y_l    (repeated until it stands),    F_jl the integrals from a to τ_j
    Y(τ) = I + h Σ_k c_k ∫_0^u P_k(2v − 1) dv,    c_k the Legendre coefficients of A Y

so that a panel is as long as the dynamics allow, however many instants it holds. Only the moving states' rows
of Y differ from those of I. Where panels are resolved by ``transition``, so are these polynomials. Of a
time-invariant system they depend on τ − a alone: panels up to twice as long as another share the longest's.

References
----------
E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, II.1 (collocation methods).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.polynomial import legendre

from obscli.numeric.collocation import gauss_legendre
from obscli.numeric.errors import NotComputableError
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import EPS, Array
from obscli.numeric.transition import NODES, not_resolved, require_derivative, summed, without


_SWEEPS: Final = 60

#: Numbers (of 8 bytes) worked on at a time.
_CHUNK: Final = 2_000_000


@dataclass(frozen=True, slots=True, eq=False)
class DenseTransition:
    """Φ(τ, a) on one panel.

    Parameters
    ----------
    start, stop : the panel
    length : of the polynomials, at least that of the panel
    moving : the states whose rows are not those of I, shape (p,)
    slopes : the Legendre coefficients of A Y over that length, shape (s, p, n)
    """

    start: float
    stop: float
    length: float
    moving: Array
    slopes: Array

    def forward(self, t: Array) -> Array:
        """Return the moving rows of Φ(t, a) at instants of the panel, shape (k, p, n)."""
        s, p, n = self.slopes.shape
        u = (t - self.start) / self.length
        flat = self.length * (_integrals(u, s) @ self.slopes.reshape(s, p * n))
        result: Array = np.eye(n)[self.moving] + flat.reshape(len(t), p, n)
        return result

    def backward(self, t: Array) -> Array:
        """Return the moving rows of Φ(a, t) at instants of the panel, shape (k, p, n)."""
        forward = self.forward(t)
        p, n = forward.shape[1:]
        right = np.zeros((len(t), p, n))
        right[:, np.arange(p), self.moving] = 1.0
        rest = np.setdiff1d(np.arange(n), self.moving)
        right[:, :, rest] = -forward[:, :, rest]
        return np.asarray(np.linalg.solve(forward[:, :, self.moving], right), dtype=float)


def dense_transitions(system: NumericSystem, edges: Array) -> Iterator[DenseTransition]:
    """Yield the transitions of the panels between edges, in order.

    Raises
    ------
    NotComputableError
        where a panel is too long, or a coefficient does not exist
    """
    require_derivative(system)
    if system.is_constant:
        yield from _shared(system, edges)
        return
    size = NODES * system.n * max(2 * len(system.moving), system.m, 1)
    at_once = max(_CHUNK // size, 1)
    for first in range(0, len(edges) - 1, at_once):
        part = edges[first : first + at_once + 1]
        slopes = _slopes(system, part[:-1], part[1:])
        for start, stop, one in zip(part[:-1], part[1:], slopes, strict=True):
            yield DenseTransition(float(start), float(stop), float(stop - start), system.moving, one)


def _shared(system: NumericSystem, edges: Array) -> Iterator[DenseTransition]:
    """Yield the transitions of a time-invariant system, one polynomial for lengths within a factor of two."""
    starts, stops, h = edges[:-1], edges[1:], np.diff(edges)
    magnitude = np.floor(np.log2(h.max() / h))
    slopes: dict[float, tuple[float, Array]] = {}
    for start, stop, key in zip(starts, stops, magnitude.tolist(), strict=True):
        if key not in slopes:
            longest = float(h[magnitude == key].max())
            slopes[key] = longest, _slopes(system, np.zeros(1), np.array([longest]))[0]
        yield DenseTransition(float(start), float(stop), slopes[key][0], system.moving, slopes[key][1])


def _slopes(system: NumericSystem, starts: Array, stops: Array) -> Array:
    """Return the Legendre coefficients of A Y on panels, shape (k, s, p, n)."""
    rule = gauss_legendre(NODES)
    moving, n = system.moving, system.n
    k, p = len(starts), len(moving)
    h = (stops - starts)[:, None]
    t = starts[:, None] + h * rule.nodes
    A = system.matrices(t.ravel())[0].reshape(k, NODES, p, n)
    inner, outer = h[..., None, None] * A[..., moving], h[..., None, None] * without(A, moving)
    base = np.eye(n)[moving] + summed(rule.forward, outer)
    inner_size, outer_size = np.abs(inner).max(axis=1), np.abs(outer).max(axis=1)
    Y = base
    for _ in range(_SWEEPS):
        before, Y = Y, base + summed(rule.forward, inner @ Y)
        largest = np.abs(Y).max(axis=1)
        change = np.abs(Y - before).max(axis=1)
        if (change <= 2 * EPS * (largest + inner_size @ largest + outer_size)).all():
            break
    else:
        _refuse_unsettled(system, starts, change, largest)
    return summed(rule.spectrum, inner @ Y + outer) / h[..., None, None]


def _refuse_unsettled(system: NumericSystem, starts: Array, change: Array, size: Array) -> None:
    """Refuse panels on which the iteration still moves by more than rounding of the whole."""
    axes = (1, 2)
    bad = ~(change.max(axis=axes, initial=0.0) <= NODES * system.n * EPS * size.max(axis=axes, initial=1.0))
    if bad.any():
        raise NotComputableError(not_resolved(system, float(starts[bad][0])))


def _integrals(u: Array, s: int) -> Array:
    """Return ∫_0^u P_k(2v − 1) dv for k < s, shape (len(u), s)."""
    x = 2 * u - 1
    P = legendre.legvander(x, s)
    k = np.arange(1, s)
    result = np.empty((len(u), s))
    result[:, 0] = u
    result[:, 1:] = (P[:, 2:] - P[:, : s - 1]) / (2 * (2 * k + 1))
    return result
