"""How much the unobservable errors change over a window: the transition matrix on the unobservable subspace.

From panel to panel t_{k-1} → t_k, with Q_k an orthonormal basis of D⁻¹ N(t_k), D the units of the states:

    C_k = Q_kᵀ D⁻¹ Φ(t_k, t_{k-1}) D Q_{k-1},     G = C_K ⋯ C_1

The singular values γ of G are by how much hidden errors shrink or grow over the window. Projecting on N at
every panel keeps out what else the system does: a rounding error along an observed direction that grows is
taken away before it does. What is taken away is the residual, and goes into the error.

Over one period of A, H and N the eigenvalues of G are the Floquet multipliers of the hidden motion.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from obscli.model.system import Covector, System
from obscli.numeric.analysis import affordable_steps
from obscli.numeric.errors import NotComputableError
from obscli.numeric.finding import HiddenMotion
from obscli.numeric.numeric_system import NumericSystem, constants_of
from obscli.numeric.program import EPS, Array, constant_value
from obscli.numeric.rates import rates_of
from obscli.numeric.settings import Effort
from obscli.numeric.transition import edges_of, longest_step, panels


_STEP_ERROR: Final = 1e-13
_PROBES: Final = 18

#: Columns of N whose angles are smaller than this are dependent at that instant.
_DEGENERATE: Final = 1e-6

#: A component of a direction below this is rounding.
_ROUNDING: Final = 1e-12

#: A residual of the projection beyond this says that the directions are not those of this system.
_NOT_INVARIANT: Final = 1e-5


def hidden_motion(
    system: System, directions: Sequence[Covector], start: float, stop: float, *, period: bool = False
) -> HiddenMotion:
    """Return by how much the unobservable errors change from start to stop.

    Parameters
    ----------
    directions : a basis of the unobservable subspace, as the exact side has it
    period : the system repeats itself after the window: its end has the same directions as its start

    Raises
    ------
    NotComputableError
        where the system cannot be integrated, or the directions are not invariant
    """
    numeric = NumericSystem(system, start, stop)
    rates = rates_of(numeric, np.linspace(start, stop, _PROBES)[1:-1])
    steps = affordable_steps(numeric)
    edges = edges_of(start, np.array([stop]), longest_step(rates), steps)
    units = units_of(system)
    first = _basis(numeric, directions, units, start)
    if first is None:
        raise NotComputableError(
            f"the unobservable directions degenerate at {start:.6g}: start elsewhere (--from)"
        )
    total, scale, error, here = np.eye(len(directions)), 0.0, 0.0, first
    for phi, end in transitions(numeric, edges, Effort(_STEP_ERROR, steps)):
        moved, rounding = _moved(phi, here, units)
        last = end == edges[-1]
        there = first if last and period else _basis(numeric, directions, units, end)
        if there is None and not last:
            there = np.linalg.qr(moved)[0]  # an isolated instant: what has moved is the basis there
        if there is None:
            raise NotComputableError(
                f"the unobservable directions degenerate at {end:.6g}: stop elsewhere (--to)"
            )
        change = there.T @ moved
        residual = np.linalg.norm(moved - there @ change) / np.linalg.norm(moved)
        if not residual < _NOT_INVARIANT:
            raise NotComputableError(f"the unobservable directions are not resolved at {end:.6g}")
        error += float(residual) + rounding
        total = change @ total
        size = np.abs(total).max()
        total, scale, here = total / size, scale + np.log(size), there
    return _described(system, total, scale, error, first * units[:, None], (start, stop))


def units_of(system: System) -> Array:
    """Return the sizes of the states: the file's `scale`, else the prior's deviations, where all have one."""
    constants = constants_of(system)
    for sizes in (
        [state.scale for state in system.states],
        [system.prior.get(s) for s in system.state_names],
    ):
        if all(size is not None for size in sizes):
            found = np.array([constant_value(size, constants) for size in sizes if size is not None])
            if (found > 0).all() and np.isfinite(found).all():
                return found
    return np.ones(system.n)


def transitions(numeric: NumericSystem, edges: Array, effort: Effort) -> Iterator[tuple[Array, float]]:
    """Yield Φ(a, b) and b of panels [a, b] in order."""
    for piece in panels(numeric, edges, effort):
        for end, rows in zip(piece.ends, piece.transition, strict=True):
            phi = np.eye(numeric.n)
            phi[numeric.moving] = rows
            yield phi, float(end)


def _moved(phi: Array, basis: Array, units: Array) -> tuple[Array, float]:
    """Return D⁻¹ Φ(b, a) D Q given Φ(a, b), and its rounding error, relative."""
    phi = phi * units / units[:, None]
    inverse = np.linalg.inv(phi)
    moved = inverse @ basis
    rounding = np.linalg.norm(np.abs(inverse) @ (np.abs(phi) @ np.abs(moved)))
    return moved, EPS * float(rounding / np.linalg.norm(moved))


def _basis(numeric: NumericSystem, directions: Sequence[Covector], units: Array, t: float) -> Array | None:
    """Return an orthonormal basis of D⁻¹ N(t), shape (n, d); None where the directions degenerate there."""
    rows = numeric.covectors(directions, np.array([t]))[0][0] / units
    if not np.isfinite(rows).all():
        return None
    size = np.linalg.norm(rows, axis=1)
    if not (size > 0).all():
        return None
    _, values, right = np.linalg.svd(rows / size[:, None], full_matrices=False)
    return right.T if values[-1] > _DEGENERATE else None


def _described(
    system: System, total: Array, scale: float, error: float, first: Array, window: tuple[float, float]
) -> HiddenMotion:
    _, gains, right = np.linalg.svd(total)
    with np.errstate(over="ignore", under="ignore"):
        factor = float(np.exp(scale))
    values, vectors = np.linalg.eig(total)
    multipliers = sorted(values * factor, key=lambda one: -abs(one))
    columns = first @ right.T
    return HiddenMotion(
        *window,
        gains=tuple(float(one) for one in gains * factor),
        directions=tuple(_named(system, column) for column in columns.T),
        error=error,
        multipliers=tuple(complex(one) for one in multipliers),
        multiplier_error=float(np.linalg.cond(vectors)) * error * float(gains[0]) * factor,
    )


def _named(system: System, column: Array) -> dict[str, float]:
    """Return a direction by state, its largest component 1, without rounding."""
    largest = column[np.abs(column).argmax()]
    column = column / largest
    return {
        name: float(value)
        for name, value in zip(system.state_names, column, strict=True)
        if abs(value) > _ROUNDING
    }
