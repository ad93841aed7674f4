"""Transition matrices from the start of a panel to any instant within it, as polynomials in time.

On a panel [a, b], h = b − a, u = (τ − a)/h, the transition Y(τ) = Φ(τ, a) satisfies Y' = A Y, Y(a) = I:

    Y_j ← I + h Σ_l F_jl A(τ_l) Y_l    (repeated until it stands),    F_jl the integrals from a to τ_j
    Y(τ) = I + h Σ_k c_k ∫_0^u P_k(2v − 1) dv,    c_k the Legendre coefficients of A Y

so that a panel is as long as the dynamics allow, however many instants it holds. Only the moving states' rows
of Y differ from those of I. Where panels are resolved by ``transition``, so are these polynomials.

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
from obscli.numeric.transition import NODES, not_resolved, require_derivative, times


_SWEEPS: Final = 60

#: Numbers (of 8 bytes) worked on at a time.
_CHUNK: Final = 2_000_000


@dataclass(frozen=True, slots=True, eq=False)
class DenseTransition:
    """Φ(τ, a) on one panel: ``slopes`` are the Legendre coefficients of A Y, shape (s, p, n)."""

    start: float
    stop: float
    moving: Array
    slopes: Array

    def forward(self, t: Array) -> Array:
        """Return the moving rows of Φ(t, a) at instants of the panel, shape (k, p, n)."""
        h = self.stop - self.start
        u = (t - self.start) / h
        s, p, n = self.slopes.shape
        flat = h * (_integrals(u, s) @ self.slopes.reshape(s, p * n))
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
    size = NODES * system.n * max(2 * len(system.moving), system.m, 1)
    at_once = max(_CHUNK // size, 1)
    for first in range(0, len(edges) - 1, at_once):
        part = edges[first : first + at_once + 1]
        slopes = _slopes(system, part[:-1], part[1:])
        for start, stop, one in zip(part[:-1], part[1:], slopes, strict=True):
            yield DenseTransition(float(start), float(stop), system.moving, one)


def _slopes(system: NumericSystem, starts: Array, stops: Array) -> Array:
    """Return the Legendre coefficients of A Y on panels, shape (k, s, p, n)."""
    rule = gauss_legendre(NODES)
    moving, n = system.moving, system.n
    k, p = len(starts), len(moving)
    h = (stops - starts)[:, None]
    t = starts[:, None] + h * rule.nodes
    A = system.matrices(t.ravel())[0].reshape(k, NODES, p, n)
    base = np.eye(n)[moving]
    Y = np.broadcast_to(base, (k, NODES, p, n))
    for _ in range(_SWEEPS):
        slope = times(A, Y, moving)
        before, Y = (
            Y,
            base + (h[..., None] * (rule.forward @ slope.reshape(k, NODES, p * n))).reshape(Y.shape),
        )
        if (np.abs(Y - before) <= 4 * EPS * np.abs(Y).max(axis=1, keepdims=True)).all():
            break
    else:
        _refuse_unsettled(system, starts, np.abs(Y - before), np.abs(Y))
    slope = times(A, Y, moving)
    coefficients: Array = (rule.spectrum @ slope.reshape(k, NODES, p * n)).reshape(k, NODES, p, n)
    return coefficients


def _refuse_unsettled(system: NumericSystem, starts: Array, change: Array, size: Array) -> None:
    """Refuse panels on which the iteration still moves by more than rounding of the whole."""
    axes = (1, 2, 3)
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
