"""Transition matrices forwards, from instant to instant, with bounds of their errors.

A panel gives Φ(a, b), and C = Φ(b, a) = Φ(a, b)⁻¹, which is well conditioned on one panel. Of a product,

    |Δ(C_K ⋯ C_1)| ≤ Σ_k |C_K ⋯ C_{k+1}| (|ΔC_k| + n ε |C_k|) |C_{k−1} ⋯ C_1|

to first order. Panels are multiplied out between the instants as long as that is well conditioned.
All in units D of the states: D⁻¹ Φ D.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from obscli.numeric.matrix_product import groups
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import EPS, Array
from obscli.numeric.settings import Effort
from obscli.numeric.transition import edges_of, panels


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """Φ(stop, start) in units of the states, ``matrix`` (n, n), and a bound of its ``error`` (n, n)."""

    start: float
    stop: float
    matrix: Array
    error: Array

    @property
    def relative_error(self) -> float:
        """The norm of the error relative to that of the matrix."""
        return float(np.linalg.norm(self.error, 2) / np.linalg.norm(self.matrix, 2))


def steps_between(
    system: NumericSystem, instants: Array, longest: float, effort: Effort, units: Array
) -> list[Step]:
    """Return the transitions from the first instant to the last, one ending at every instant.

    Parameters
    ----------
    instants : in order, at least two, shape (k + 1,)
    longest : the longest panel to begin with
    units : D, shape (n,)

    Raises
    ------
    NotComputableError
        where a panel cannot be resolved, or there would be too many
    """
    found: list[Step] = []
    part: list[Step] = []
    ends = set(instants[1:].tolist())
    for one in _forward(
        system, edges_of(instants[0], instants[1:], longest, effort.most_steps), effort, units
    ):
        part.append(one)
        if one.stop in ends:
            found += _merged(part)
            part = []
    found[-1] = _rounded_end(system, found[-1], units)
    return found


def product(steps: Sequence[Step]) -> Step:
    """Return the transition over all steps, with its error; not finite where no number is so large."""
    with np.errstate(over="ignore", invalid="ignore"):
        before = [np.eye(len(steps[0].matrix))]
        for one in steps:
            before.append(one.matrix @ before[-1])
        after, error = np.eye(len(before[0])), np.zeros_like(before[0])
        for one, first in zip(reversed(steps), before[-2::-1], strict=True):
            local = one.error + len(after) * EPS * np.abs(one.matrix)
            error += np.abs(after) @ local @ np.abs(first)
            after = after @ one.matrix
    return Step(steps[0].start, steps[-1].stop, before[-1], error)


def _rounded_end(system: NumericSystem, step: Step, units: Array) -> Step:
    """Return the step whose end is known but for the rounding of its instant, Φ' = A Φ."""
    A = np.zeros_like(step.matrix)
    A[system.moving] = np.abs(system.matrices(np.array([step.stop]))[0][0])
    moved = np.spacing(abs(step.stop)) * (A * units / units[:, None]) @ np.abs(step.matrix)
    return replace(step, error=step.error + moved)


def _merged(steps: Sequence[Step]) -> list[Step]:
    """Return the steps multiplied out as long as the product is well conditioned."""
    first, found = 0, []
    for end in groups([one.matrix for one in steps]):
        found.append(product(steps[first:end]) if end - first > 1 else steps[first])
        first = end
    return found


def _forward(system: NumericSystem, edges: Array, effort: Effort, units: Array) -> Iterator[Step]:
    ratio, start, n = units / units[:, None], float(edges[0]), system.n
    for piece in panels(system, edges, effort):
        for end, rows, squared in zip(piece.ends, piece.transition, piece.transition_error, strict=True):
            phi, error = np.eye(n), np.zeros((n, n))
            phi[system.moving], error[system.moving] = rows, np.sqrt(squared)
            error += EPS * np.abs(phi)
            matrix = np.linalg.inv(phi)
            wrong = np.abs(matrix) @ (error + n * EPS * np.abs(phi)) @ np.abs(matrix)
            still = system.constant_states
            wrong[still] = 0
            matrix[still] = np.eye(n)[still]
            yield Step(start, float(end), matrix * ratio, wrong * ratio)
            start = float(end)
