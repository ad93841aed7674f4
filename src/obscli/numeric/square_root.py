"""The Gramian as a square root, carried from panel to panel, and its error carried beside it.

On a panel [a, b] with W(a) = Rᵀ R, nodes τ_j and weights w_j:

    W(b) = [R Φ(a, b); √w_j H(τ_j) Φ(τ_j, b)]ᵀ [ … ],    R ← qr [ … ]

Forming W would square the condition number. Rows are triangularised at the instants, and where they become
many. The rounding error of that is relative to the columns, so the units of the states do not matter; columns
that grow or fade are rescaled by powers of two, which is exact.

The error ΔR is carried as |ΔR v|² ≲ vᵀ E v with

    E(b) = Φᵀ E(a) Φ + diag(ε² |column|²),    ε from rounding, from the step and from the coefficients.

Roundings of one factorisation are taken as random, ε = √(n/24) units beyond 24 states; the errors of the
transport from panel to panel, which repeats itself, as partly alike, √(k + k²/9) units after k panels.

References
----------
V. M. Morozov, F. Yu. Baklanov (2018), (2), (3). N. J. Higham, Accuracy and Stability of Numerical Algorithms,
19.3 (columnwise error of the Householder factorisation).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Final, Protocol, TypeAlias

import numpy as np

from obscli.numeric.gramian import LOST, Gramian, squared_rounding
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.panels import Panels
from obscli.numeric.program import Array
from obscli.numeric.rates import Rates
from obscli.numeric.settings import Effort
from obscli.numeric.transition import edges_of, longest_step, panels, times


#: Rows are triangularised when they are more than so many per state.
_GATHERED: Final = 3

#: Every so many panels (one grows by e^2 at the most) columns are looked at: they are rescaled when their
#: norm leaves [2^-k, 2^k], and given up when their units leave [2^-K, 2^K].
_WATCHED: Final = 8
_RANGE: Final = 64
_LARGEST: Final = 450

#: R (n, n), the units (n,), E (n, n) and ln of the growth at one instant.
Snapshot: TypeAlias = tuple[Array, Array, Array, float]

#: Up to so many states whole products are faster than those of the moving rows alone.
_DENSE: Final = 50


def square_root_gramian(
    system: NumericSystem, start: float, instants: Array, rates: Rates, effort: Effort
) -> Gramian:
    """Return R(t_i) for W(t_i, t0) at all instants; R = 0 with error ``LOST`` where columns grow too far.

    Parameters
    ----------
    start, instants : t0, and t_i in order, shape (N,)
    rates : of the system on the interval: they bound the steps
    effort : step error allowed, relative to each entry of A Φ, and how many steps

    Raises
    ------
    NotComputableError
        where the coefficients cannot be resolved, or do not exist at some instant
    """
    edges = edges_of(start, instants, longest_step(rates), effort.most_steps)
    return carried(panels(system, edges, effort), system, start, instants)


class Carried(Protocol):
    """A system of which rows are carried: the number of states, and those whose rows of Φ are given."""

    @property
    def n(self) -> int:
        """The number of states."""

    @property
    def moving(self) -> Array:
        """The states that move."""


def carried(pieces: Iterable[Panels], system: Carried, start: float, instants: Array) -> Gramian:
    """Return R(t_i) from panels of which one ends at every instant; lost where columns grow too far.

    Parameters
    ----------
    pieces : consecutive panels from t0 on
    system : whose panels they are
    start, instants : t0, and t_i in order, shape (N,)
    """
    chain = Chain(system)
    return gathered(snapshots(pieces, chain, instants), start, instants)


def snapshots(pieces: Iterable[Panels], chain: Chain, instants: Array) -> list[Snapshot]:
    """Return what the chain is at instants, on its way through panels of which one ends at each of them."""
    found: list[Snapshot] = []
    for piece in pieces:
        with np.errstate(all="ignore"):  # where squares are too large all is lost
            squares = np.einsum("kij,kij->kj", piece.rows, piece.rows)
            for k, end in enumerate(piece.ends):
                chain.advance(piece, k, squares[k])
                if end == instants[len(found)]:
                    found.append(chain.snapshot())
    return found


def gathered(found: Sequence[Snapshot], start: float, instants: Array) -> Gramian:
    """Return R(t_i) from what the chain was at all instants; lost where columns grew too far."""
    matrices, units, error, growth = (np.array(part) for part in zip(*found, strict=True))
    lost = ~np.isfinite(error).all(axis=(1, 2))
    matrices[lost], units[lost], error[lost] = 0.0, 1.0, LOST * np.eye(matrices.shape[-1])
    starts = np.full(len(instants), start)
    return Gramian("square-root", instants, starts, matrices, units, error, growth)


class Chain:
    """Rows S with W = Sᵀ S and the error matrix E at the end of the last panel, states in units 2^e."""

    def __init__(self, system: Carried) -> None:
        n = system.n
        self._moving = system.moving
        self._identity = np.eye(n)
        self._rounding = squared_rounding(n)
        self._rows = np.zeros((0, n))
        self._squares = np.zeros(n)
        self._error = np.zeros((n, n))
        self._units = self._squared_units = np.ones(n)
        self._ratio = self._squared_ratio = np.ones((len(self._moving), n))
        self._count = 0
        self._growth = 0.0
        self._lost = False

    def advance(self, piece: Panels, k: int, squares: Array) -> None:
        """Take in one panel, given the squared norms of the columns of its rows."""
        if self._lost:
            return
        transition = piece.transition[k] * self._ratio
        carried, error = self._transported(self._rows, self._error, transition)
        before, moved = self._squares, np.einsum("ij,ij->j", carried, carried)
        squares = squares * self._squared_units
        self._error = error
        self._rows = np.concatenate([carried, piece.rows[k] * self._units])
        self._squares = moved + squares
        self._add(
            (self._rounding * (1 + (2 * self._count + 1) / 9)) * moved
            + (self._rounding / 4) * squares
            + piece.row_error[k] * self._squared_units
            + (1 + 2 * self._count / 9)
            * (before[self._moving] @ (piece.transition_error[k] * self._squared_ratio))
        )
        self._growth += _growth(before.sum(), moved.sum())
        self._count += 1
        if self._count % _WATCHED == 0:
            self._keep_in_range()
        if len(self._rows) > _GATHERED * self._rows.shape[1]:
            self._triangularise()

    def enter(self, system: NumericSystem) -> None:
        """Go on with the panels of another system over the same states."""
        self._moving = system.moving
        self._set_ratios()

    def jump(self, inverse: Array) -> None:
        """Let the state jump, x⁺ = J x, given J⁻¹ to rounding: R⁺ = R J⁻¹."""
        if self._lost:
            return
        step = inverse * self._units / self._units[:, None]
        size = np.abs(self._rows) @ np.abs(step)
        self._rows = self._rows @ step
        self._error = step.T @ self._error @ step
        self._squares = np.einsum("ij,ij->j", self._rows, self._rows)
        self._add(self._rounding * len(step) * np.einsum("ij,ij->j", size, size))

    def snapshot(self) -> Snapshot:
        """Return R (n, n), the units (n,), E (n, n) and ln of the growth as they stand."""
        n = self._rows.shape[1]
        if self._lost:
            return np.zeros((n, n)), np.ones(n), np.full((n, n), np.inf), self._growth
        self._triangularise()
        factor = np.zeros((n, n))
        factor[: len(self._rows)] = self._rows
        return factor, self._units, self._error.copy(), self._growth

    def _transported(self, rows: Array, error: Array, transition: Array) -> tuple[Array, Array]:
        """Return rows Φ(a, b) and Φᵀ E Φ, given the moving states' rows of Φ."""
        if len(self._identity) <= _DENSE:
            whole = self._identity.copy()
            whole[self._moving] = transition
            return rows @ whole, whole.T @ error @ whole

        halfway = times(error, transition, self._moving).T
        return times(rows, transition, self._moving), times(halfway, transition, self._moving)

    def _triangularise(self) -> None:
        self._rows = _triangle(self._rows)
        self._add(self._rounding * self._squares)

    def _add(self, local: Array) -> None:
        """Add to the diagonal of E."""
        self._error.flat[:: len(local) + 1] += local

    def _keep_in_range(self) -> None:
        size = np.sqrt(self._squares)
        exponent = np.zeros(len(size))
        np.log2(size, out=exponent, where=size > 0)
        if np.abs(exponent).max(initial=0.0) > _RANGE:
            self._rescale(2.0 ** -np.round(exponent))

    def _rescale(self, factor: Array) -> None:
        self._rows *= factor
        self._squares *= factor**2
        self._error *= factor * factor[:, None]
        self._units = self._units * factor
        self._set_ratios()
        exponents = np.log2(self._units)
        if max(np.abs(exponents).max(), exponents.max() - exponents.min()) > _LARGEST:
            self._lost = True

    def _set_ratios(self) -> None:
        self._ratio = self._units / self._units[self._moving][:, None]
        self._squared_units, self._squared_ratio = self._units**2, self._ratio**2


def _triangle(rows: Array) -> Array:
    triangle: Array = np.linalg.qr(rows, mode="r")  # type: ignore[assignment]  # no QRResult in this mode
    return triangle


def _growth(before: float, after: float) -> float:
    """Return ln of by how much the rows have grown, given the sums of their squares; 0 if they have not."""
    return max(math.log(after / before), 0.0) / 2 if before > 0 < after else 0.0
