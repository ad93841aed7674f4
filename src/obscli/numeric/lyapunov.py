"""The Gramian by its differential equation (3), as the papers integrate it.

    dW/dt = −Aᵀ W − W A + Hᵀ H,    W(t0, t0) = 0

with an explicit Runge–Kutta method of order 8 (DOP853). Units of the states follow the size of W, so that the
tolerance is relative to it however it grows: with Z = U W U, U = diag(u) and u'/u constant on pieces,

    dZ/dt = −Bᵀ Z − Z B + (H U)ᵀ H U,    B = U⁻¹ A U − diag(u'/u)

The integration is made a second time with ten times the tolerance; the difference of the two, and what is
below the absolute tolerance, is the error that the rank decision is told of. W is the square of what
``square_root`` finds: so are its singular values, and half of the digits are gone.

References
----------
V. M. Morozov, F. Yu. Baklanov (2018), (3). E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential
Equations I, II.10.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count
from typing import Final

import numpy as np

from obscli.numeric.errors import NotComputableError
from obscli.numeric.gramian import Gramian, diagonal_root, unit_diagonal
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import EPS, Array
from obscli.numeric.rates import Rates
from obscli.numeric.settings import Effort
from obscli.numeric.square_root import square_root_gramian
from obscli.numeric.transition import edges_of, longest_step


#: The integration whose difference is the error estimate is this much coarser.
_COARSER: Final = 10.0

#: Entries are held to rtol down to this fraction of their size in units of the states.
_FLOOR: Final = 1e-3

#: The integrator is stopped after so many evaluations on a piece.
_MOST_CALLS: Final = 200_000
_GIVEN_UP: Final = (
    "equation (3) could not be integrated: {}; --gramian square-root takes fast and stiff systems"
)

#: A piece reaches back as long as no root of W's diagonal falls below this share of its size at the end.
_SHARE: Final = 0.1


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """A stretch of time, the units u at its end, and u'/u on it, shape (n,) each."""

    start: float
    stop: float
    units: Array
    rate: Array

    def units_at(self, t: float) -> Array:
        """Return u(t)."""
        found: Array = self.units * np.exp(self.rate * (t - self.stop))
        return found


def lyapunov_gramian(
    system: NumericSystem, start: float, instants: Array, rates: Rates, effort: Effort
) -> Gramian:
    """Return W(t_i, t0) at all instants.

    Parameters
    ----------
    start, instants : t0, and t_i in order, shape (N,)
    rates : for the sizes of the states only: the integrator finds its own steps
    effort : tolerance of the integrator, relative to each entry of W, is its step error

    Raises
    ------
    NotComputableError
        where the integrator gives up, or a coefficient does not exist
    """
    knots = edges_of(start, instants, longest_step(rates), effort.most_steps)[1:]
    roots = square_root_gramian(system, start, knots, rates, effort)
    pieces = _pieces(start, knots, np.linalg.norm(roots.matrices, axis=1) / roots.units)
    fine = _integrate(system, instants, pieces, effort.rtol)
    coarse = _integrate(system, instants, pieces, _COARSER * effort.rtol)
    with np.errstate(invalid="ignore", over="ignore"):
        size = diagonal_root(fine)
        change = (fine - coarse) / size[:, :, None] / size[:, None, :]
        sizes = 1 / np.array([next(p for p in pieces if t <= p.stop).units_at(t) for t in instants])
        below = _FLOOR * effort.rtol * ((sizes / size) ** 2).sum(axis=1)
        spread = np.linalg.norm(change, axis=(1, 2)) + below + system.n * EPS
        error = spread[:, None, None] ** 2 * np.eye(system.n)
        return unit_diagonal("lyapunov", instants, start, fine, error)


def _pieces(start: float, knots: Array, sizes: Array) -> list[Piece]:
    """Return the pieces in order, given the roots of W's diagonal at the knots, shape (k, n)."""
    sizes = np.where((sizes > 0) & np.isfinite(sizes), sizes, 1.0)
    ends = [len(knots) - 1]
    for i in reversed(range(len(knots) - 1)):
        if (sizes[i] < _SHARE * sizes[ends[-1]]).any():
            ends.append(i)
    pieces: list[Piece] = []
    before = ends[-1]
    for end in reversed(ends):
        a = pieces[-1].stop if pieces else start
        rate = np.log(sizes[before] / sizes[end]) / (knots[end] - a)
        pieces.append(Piece(a, float(knots[end]), 1 / sizes[end], rate))
        before = end
    return pieces


def _integrate(system: NumericSystem, instants: Array, pieces: Sequence[Piece], rtol: float) -> Array:
    """Return W at the instants in the file's units, shape (N, n, n)."""
    W, found = np.zeros((system.n, system.n)), []
    for piece in pieces:
        inside = instants[(instants > piece.start) & (instants <= piece.stop)]
        wanted = np.union1d(inside, [piece.stop])
        u = piece.units_at(piece.start)
        Z = _integrate_piece(system, piece, wanted, W * u * u[:, None], rtol)
        units = np.array([piece.units_at(t) for t in wanted])
        parts = Z / units[:, :, None] / units[:, None, :]
        found.append(parts[: len(inside)])
        W = parts[-1]
    return np.concatenate(found)


def _integrate_piece(
    system: NumericSystem, piece: Piece, instants: Array, initial: Array, rtol: float
) -> Array:
    """Return Z at instants of a piece, shape (N, n, n), given Z at its start."""
    from scipy.integrate import solve_ivp  # noqa: PLC0415 - half a second to import, for this method only

    n, moving, calls = system.n, system.moving, count()

    def right_side(t: float, z: Array) -> Array:
        if next(calls) > _MOST_CALLS:
            raise NotComputableError(_GIVEN_UP.format(f"more than {_MOST_CALLS} evaluations"))
        A, H = system.matrices(np.array([t]))
        u = piece.units_at(t)
        h, Z = H[0] * u, z.reshape(n, n)
        product = Z[:, moving] @ (A[0] * u / u[moving][:, None]) - Z * piece.rate
        change: Array = h.T @ h - product - product.T
        return change.ravel()

    with np.errstate(over="ignore", invalid="ignore"):
        found = solve_ivp(
            right_side,
            (piece.start, piece.stop),
            initial.ravel(),
            method="DOP853",
            t_eval=instants,
            rtol=rtol,
            atol=_FLOOR * rtol,
        )
    if not found.success:
        raise NotComputableError(_GIVEN_UP.format(found.message.rstrip(".").lower()))
    Z: Array = found.y.T.reshape(len(instants), n, n)
    return Z
