"""Panels of a discrete-time system from its first sample on, for rows that are carried forward.

    R(k₀) = H(k₀),    R(k) ← qr [R(k−1) F⁻¹(k−1); H(k)],    W(k, k₀) = R(k)ᵀ R(k)

It is the Gramian of x(k) from the outputs up to k. F has to be invertible: where it is not, what it takes to
zero is lost on the way, and nothing can be said of the state before.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from obscli.numeric.discrete_gramian import MOST_STEPS
from obscli.numeric.errors import NotComputableError, TooManyStepsError
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.panels import Panels
from obscli.numeric.program import EPS, Array


#: Numbers (of 8 bytes) worked on at a time.
_CHUNK: Final = 2_000_000


def forward_steps(system: NumericSystem, start: float, stop: float, *, first: bool) -> Iterator[Panels]:
    """Yield F⁻¹(k − 1), H(k) with their errors for k in (start, stop], in pieces that fit into memory.

    Parameters
    ----------
    first : whether the sample at the start is taken, too

    Raises
    ------
    NotComputableError
        where a coefficient does not exist at some step, F cannot be undone, or the steps are too many
    """
    if stop - start > MOST_STEPS:
        raise TooManyStepsError(f"more than {MOST_STEPS} steps: choose shorter segments")
    n = system.n
    at_once = max(_CHUNK // (n * (n + system.m)), 1)
    every = np.arange(start + 1, stop + 1)
    if first:
        here = system.coefficients(np.array([start]))
        none = np.zeros((1, n, n))
        yield Panels(np.array([start]), np.eye(n)[None], here.H, none, (here.H_error**2).sum(axis=1))
    for begin in range(0, len(every), at_once):
        k = every[begin : begin + at_once]
        before, found = system.coefficients(k - 1), system.coefficients(k)
        inverse, error = _undone(before.A, before.A_error, k - 1)
        yield Panels(
            ends=k,
            transition=inverse,
            rows=found.H,
            transition_error=error**2,
            row_error=(found.H_error**2).sum(axis=1),
        )


def _undone(F: Array, error: Array, k: Array) -> tuple[Array, Array]:
    """Return F⁻¹ and its error: |F⁻¹| (|ΔF| + n ε |F|) |F⁻¹|."""
    n = F.shape[-1]
    size = np.linalg.norm(F, axis=1, keepdims=True)
    condition = np.linalg.cond(F / np.where(size > 0, size, 1.0))  # infinite where a column is zero
    singular = np.flatnonzero(~(condition < 1 / (n * EPS)))
    if singular.size:
        raise NotComputableError(
            f"F at step {k[singular[0]]:.6g} cannot be undone: a combination of the states is lost in it, so "
            "that the outputs before say nothing of it afterwards"
        )
    inverse: Array = np.asarray(np.linalg.inv(F), dtype=float)
    away = np.abs(inverse) @ (error + n * EPS * np.abs(F)) @ np.abs(inverse)
    return inverse, away
