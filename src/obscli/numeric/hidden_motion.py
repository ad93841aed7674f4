"""How much the unobservable errors change over a window: the transition matrix on the unobservable subspace.

From panel to panel t_{k-1} → t_k, with Q_k an orthonormal basis of D⁻¹ N(t_k), D the units of the states:

    C_k = Q_kᵀ D⁻¹ Φ(t_k, t_{k-1}) D Q_{k-1},     G = C_K ⋯ C_1

The singular values γ of G are by how much hidden errors shrink or grow over the window. Projecting on N at
every panel keeps out what else the system does: a rounding error along an observed direction that grows is
taken away before it does. What is taken away is the residual, and goes into the error of C_k, as do the step
error and the rounding of Φ. G is never multiplied out, so that small γ are as accurate as large ones.

Over one period P of A, H and N the eigenvalues μ of G are the Floquet multipliers of the hidden motion, and
ln μ/P its exponents.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from obscli.model.system import Covector, System
from obscli.numeric.analysis import affordable_steps
from obscli.numeric.errors import NotComputableError
from obscli.numeric.finding import FloquetMode, HiddenMotion
from obscli.numeric.numeric_system import NumericSystem, constants_of
from obscli.numeric.product_eigenvalues import Eigenvalue
from obscli.numeric.product_spectrum import Spectrum, product_spectrum
from obscli.numeric.program import EPS, Array, constant_value
from obscli.numeric.rates import rates_of
from obscli.numeric.settings import Effort
from obscli.numeric.transition import edges_of, longest_step, panels


_STEP_ERROR: Final = 1e-13
_PROBES: Final = 18

#: Columns of N whose angles are smaller than this are dependent at that instant, and those whose rounding is
#: larger are not known there: what has moved from the instant before is taken instead.
_DEGENERATE: Final = 1e-4
_INEXACT: Final = 1e-12

#: A component of a direction below this is rounding.
_ROUNDING: Final = 1e-12

#: A residual of the projection beyond this says that the directions are not those of this system.
_NOT_INVARIANT: Final = 1e-5

#: Factors less certain than this are not shown.
_UNRESOLVED: Final = 0.1

#: The largest number; beyond it a complex number has no direction.
_LARGEST: Final = float(np.finfo(float).max)


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
    subspace = _Subspace(numeric, directions, units)
    factors: list[Array] = []
    errors: list[float] = []
    first, here = None, np.empty((0, 0))
    for step in _steps(numeric, edges, Effort(_STEP_ERROR, steps), units):
        if first is None:
            first = here = subspace.first(step)
        moved, error = step.moved(here)
        there = first if period and step.end == edges[-1] else subspace.basis(step.end)
        if there is None:  # an isolated instant: what has moved is the basis there
            there = np.linalg.qr(moved)[0]
        factors.append(there.T @ moved)
        size = np.linalg.norm(factors[-1], 2)
        residual = np.linalg.norm(moved - there @ factors[-1], 2) / size
        if not residual < _NOT_INVARIANT:
            raise NotComputableError(f"the unobservable directions are not resolved at {step.end:.6g}")
        errors.append(float(residual + error / size))
        here = there
    assert first is not None
    spectrum = product_spectrum(factors, errors, eigenvalues=period)
    if not spectrum.gain_errors[0] < _UNRESOLVED:
        raise NotComputableError("the motion of the unobservable directions is lost in rounding")
    return _described(system, spectrum, first * units[:, None], (start, stop))


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


@dataclass(frozen=True, slots=True, eq=False)
class _Step:
    """D⁻¹ Φ(start, end) D, shape (n, n), and its error by steps and rounding."""

    end: float
    start: float
    backward: Array
    error: Array

    def moved(self, basis: Array) -> tuple[Array, float]:
        """Return D⁻¹ Φ(end, start) D Q, and the norm of its error."""
        inverse = np.linalg.inv(self.backward)
        moved = inverse @ basis
        return moved, float(np.linalg.norm(np.abs(inverse) @ (self.error @ np.abs(moved))))


def _steps(numeric: NumericSystem, edges: Array, effort: Effort, units: Array) -> Iterator[_Step]:
    ratio = units / units[:, None]
    start = float(edges[0])
    for piece in panels(numeric, edges, effort):
        for end, rows, squared in zip(piece.ends, piece.transition, piece.transition_error, strict=True):
            phi, error = np.eye(numeric.n), np.zeros((numeric.n, numeric.n))
            phi[numeric.moving], error[numeric.moving] = rows, np.sqrt(squared)
            phi, error = phi * ratio, error * ratio
            yield _Step(float(end), start, phi, error + EPS * np.abs(phi))
            start = float(end)


class _Subspace:
    """Orthonormal bases of D⁻¹ N(t)."""

    def __init__(self, numeric: NumericSystem, directions: Sequence[Covector], units: Array) -> None:
        self._numeric = numeric
        self._directions = directions
        self._units = units

    def basis(self, t: float) -> Array | None:
        """Return a basis at an instant, (n, d); None where directions degenerate, or are rounding."""
        found, wrong = (
            one[0] / self._units for one in self._numeric.covectors(self._directions, np.array([t]))
        )
        if not np.isfinite(found).all():
            return None
        size = np.linalg.norm(found, axis=1)
        if not (size > 0).all() or np.linalg.norm(wrong / size[:, None]) > _INEXACT:
            return None
        _, values, right = np.linalg.svd(found / size[:, None], full_matrices=False)
        return right.T if values[-1] > _DEGENERATE else None

    def first(self, step: _Step) -> Array:
        """Return a basis at the start of the first step, where needed by moving that at its end back."""
        found = self.basis(step.start)
        if found is not None:
            return found
        after = self.basis(step.end)
        if after is None:
            raise NotComputableError(
                f"the unobservable directions degenerate at {step.start:.6g}: start elsewhere (--from)"
            )
        return np.linalg.qr(step.backward @ after)[0]


def _described(system: System, spectrum: Spectrum, first: Array, window: tuple[float, float]) -> HiddenMotion:
    length = window[1] - window[0]
    columns = first @ spectrum.right.T
    eigenvalues = zip(spectrum.eigenvalues, spectrum.eigenvalue_errors, strict=True)
    return HiddenMotion(
        *window,
        gains=tuple(_exp(one, np.inf) for one in spectrum.gains),
        exponents=tuple(float(one) / length for one in spectrum.gains),
        errors=tuple(float(one) for one in spectrum.gain_errors),
        directions=tuple(named(system, column) for column in columns.T),
        floquet=tuple(_mode(system, *one, first, length) for one in eigenvalues),
    )


def _mode(system: System, one: Eigenvalue, error: float, first: Array, period: float) -> FloquetMode:
    vector = first @ one.vector
    vector = vector / vector[np.abs(vector).argmax()]
    part = vector.real if one.phase.imag >= 0 else vector.imag
    apart = abs(one.log_modulus) > -np.log1p(-min(error, 0.5))
    return FloquetMode(
        multiplier=_exp(one.log_modulus, _LARGEST) * one.phase,
        exponent=complex(one.log_modulus / period, float(np.angle(one.phase)) / period),
        error=float(error),
        kind=("growing" if one.log_modulus > 0 else "decaying") if apart else "neutral",
        direction=named(system, part),
    )


def _exp(x: float, most: float) -> float:
    """Return e^x, no more than ``most``."""
    with np.errstate(over="ignore", under="ignore"):
        return float(min(np.exp(x), most))


def named(system: System, column: Array) -> dict[str, float]:
    """Return a direction by state, its largest component 1, without rounding."""
    largest = column[np.abs(column).argmax()]
    column = column / largest
    return {
        name: float(value)
        for name, value in zip(system.state_names, column, strict=True)
        if abs(value) > _ROUNDING
    }
