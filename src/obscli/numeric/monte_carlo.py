"""Runs of a Kalman filter with random errors, all runs at once, and whether they spread as the filter says.

Every run is a column of errors (z, ε), see ``joint_errors``, driven and measured with noise of its own and
corrected with the same gains. Averages over N runs of

    NEES  eᵀ P⁻¹ e,  over n degrees of freedom (the rank of P),    NIS  νᵀ S⁻¹ ν,  over the outputs sampled

times N n have the χ² distribution of N n degrees of freedom where the filter is consistent. Numbers are drawn
at every sample and panel, whatever is recorded: the same seed gives the same runs.

References
----------
Y. Bar-Shalom, X. R. Li, T. Kirubarajan, Estimation with Applications to Tracking and Navigation (2001), 5.4.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from obscli.numeric.chi_squared import chi_squared_band
from obscli.numeric.errors import NotComputableError
from obscli.numeric.joint_errors import Known
from obscli.numeric.program import Array
from obscli.numeric.progress import Progress, silent
from obscli.numeric.recorded_errors import RecordedErrors
from obscli.numeric.simulation_finding import Consistency, MonteCarlo


_CONFIDENCE: Final = 0.95

#: Where P in units of its deviations has smaller eigenvalues than the square of this, it is singular.
_SINGULAR: Final = 1e-12


@dataclass(frozen=True, slots=True, eq=False)
class _Recorded:
    """At one instant: of the forms mean, rms and claimed deviation; sums over runs and degrees of freedom."""

    mean: Array
    rms: Array
    claimed: Array
    nees: tuple[float, int] | None
    nis: tuple[float, int] | None


def monte_carlo(
    run: RecordedErrors, runs: int, seed: int, progress: Progress = silent, initial: Array | None = None
) -> MonteCarlo:
    """Return how the errors of a filter spread.

    Parameters
    ----------
    run : the filter on the truth
    runs, seed : how many, and the seed of the generator
    progress : told where the runs are; an interrupt keeps what is done
    initial : errors that the true states have at the start of every run, shape (n_x,); not a number, as
        without them: drawn from P0

    Raises
    ------
    NotComputableError
        where the covariance is beyond all numbers, or for less than one run
    """
    if runs < 1:
        raise NotComputableError(f"{runs} runs: at least one is needed (--runs)")
    pair = run.pair
    root = pair.truth.prior
    given = np.full(len(root), np.nan) if initial is None else initial
    root[~np.isnan(given)] = 0.0
    draws = _Draws(pair.joint(root), pair.states, np.random.Generator(np.random.PCG64(seed)), runs)
    draws.shift(pair.joint(np.nan_to_num(given)[:, None]))

    def seen(known: Known, rows: Array) -> _Recorded:
        return _recorded(known, rows, draws.columns)

    found, complete = run.look(draws, seen, progress)
    done, forms = run.t[: len(found)], run.forms
    shape = (len(found), len(forms.names))
    return MonteCarlo(
        forms.names,
        forms.kinds,
        runs,
        seed,
        done,
        np.array([one.mean for one in found]).reshape(shape),
        np.array([one.rms for one in found]).reshape(shape),
        np.array([one.claimed for one in found]).reshape(shape),
        _consistency(done, [one.nees for one in found], runs),
        _consistency(done, [one.nis for one in found], runs),
        _CONFIDENCE,
        complete,
        not np.isnan(given).all(),
    )


class _Draws:
    """Draws of (z, ε), one a column."""

    def __init__(self, root: Array, states: int, generator: np.random.Generator, runs: int) -> None:
        self._generator = generator
        self._states = states
        self._runs = runs
        self._draws = self._drawn(root)

    @property
    def columns(self) -> Array:
        return self._draws

    def shift(self, column: Array) -> None:
        """Add the same to all draws."""
        self._draws += column

    def add(self, root: Array) -> None:
        self._draws += self._drawn(root)

    def correct(self, rows: Array, noise: Array, gain: Array) -> Array:
        innovation = rows @ self._draws + self._drawn(noise)
        self._draws[self._states :] -= gain @ innovation
        return innovation

    def move(self, transition: Array) -> None:
        self._draws = transition @ self._draws

    def _drawn(self, root: Array) -> Array:
        found: Array = root @ self._generator.standard_normal((root.shape[1], self._runs))
        return found


def _recorded(known: Known, rows: Array, draws: Array) -> _Recorded:
    errors = known.error_transition @ draws
    root = known.filter_transition @ known.root
    forms = rows @ errors
    nis = None if known.innovation is None else (float((known.innovation**2).sum()), known.outputs)
    return _Recorded(
        forms.mean(axis=1),
        np.sqrt((forms**2).mean(axis=1)),
        np.linalg.norm(rows @ root, axis=1),
        _normalised(root, errors),
        nis,
    )


def _normalised(root: Array, errors: Array) -> tuple[float, int] | None:
    """Return the sum over the draws of eᵀ P⁻¹ e on the range of P = L Lᵀ, and its rank; None where P is 0."""
    units = np.maximum(np.linalg.norm(root, axis=1), np.finfo(float).tiny)[:, None]
    left, values, _ = np.linalg.svd(root / units)
    rank = int((values > _SINGULAR * values[0]).sum())
    if not rank:
        return None
    whitened = (left.T @ (errors / units))[:rank] / values[:rank, None]
    return float((whitened**2).sum()), rank


def _consistency(t: Array, found: Sequence[tuple[float, int] | None], runs: int) -> Consistency | None:
    """Return the averages at the instants that have one; None where none has."""
    at = [k for k, one in enumerate(found) if one is not None]
    sums = [one for one in found if one is not None]
    if not sums:
        return None
    total, degrees = np.array(sums, dtype=float).reshape(-1, 2).T
    degrees = degrees * runs
    lower, upper = chi_squared_band(degrees, _CONFIDENCE)
    average = total / degrees
    inside = (average >= lower) & (average <= upper)
    return Consistency(t[at], average, lower, upper, degrees, float(inside.mean()))
