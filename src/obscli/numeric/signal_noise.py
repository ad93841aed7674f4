"""The noise of signals: added once more, or taken out as far as its size allows.

Of a record y_i = s̄_i + e_i only the deviation σ of e is known. Added is white noise of that size. Taken out
is as much as leaves the calmest record that noise of that size explains: of all s with rms(s − y) ≤ ρ the
one that moves least,

    min Σ_i (s_{i+1} − s_i)² / (t_{i+1} − t_i),    (μ I + L) s = μ y,

L the tridiagonal matrix of that form, μ such that rms(s − y) = ρ. Where a constant is within ρ it is that
constant. ρ = σ (1 + 3/√(2N)): the rms of N draws may come out as large.

References
----------
E. T. Whittaker, On a New Method of Graduation (1923); V. A. Morozov for the choice of μ by the noise.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from obscli.numeric.program import Array
from obscli.numeric.signals import Changed, Samples, slopes_of


#: The rms of N draws is within so many of its deviations σ/√(2N) of σ.
_CHANCE: Final = 3.0

#: Of μ in units of 1/step: from where a record is nearly a constant to where it is nearly itself.
_LEAST: Final = 1e-14
_MOST: Final = 1e8
_HALVINGS: Final = 40


def noisier(deviations: Mapping[str, float], draw: int) -> Changed:
    """Return what adds white noise to samples; another draw for every number and entry of ``signals``.

    Parameters
    ----------
    deviations : of the noise, by function
    draw : its number
    """

    def changed(entry: int, samples: Samples) -> Samples:
        places = [k for k, name in enumerate(samples.names) if name in deviations]
        sizes = np.array([deviations[samples.names[k]] for k in places])
        seed = [draw, entry]
        noise = sizes * np.random.default_rng(seed).standard_normal((len(samples.t), len(places)))
        values = samples.values.copy()
        values[:, places] += noise
        return _with(samples, values)

    return changed


def calmed(deviations: Mapping[str, float]) -> Changed:
    """Return what takes noise out of samples: the calmest record left that it explains."""

    def changed(_: int, samples: Samples) -> Samples:
        values = samples.values.copy()
        for k, name in enumerate(samples.names):
            if name in deviations:
                values[:, k] = calmest(samples.t, values[:, k], deviations[name])
        return _with(samples, values)

    return changed


def calmest(t: Array, y: Array, deviation: float) -> Array:
    """Return the s that moves least of all with rms(s − y) ≤ ρ, shape (N,)."""
    from scipy.linalg import solveh_banded  # noqa: PLC0415 - for signals with noise only

    allowed = deviation * (1 + _CHANCE / np.sqrt(2 * len(y)))
    constant = np.full(len(y), y.mean())
    if _rms(constant - y) <= allowed:
        return constant
    w = 1 / np.diff(t)
    bands = np.zeros((2, len(y)))
    bands[0, 1:] = -w
    bands[1, :-1] += w
    bands[1, 1:] += w

    def solved(exponent: float) -> Array:
        mu = np.exp(exponent) * float(np.median(w))
        shifted = bands + np.array([[0.0], [mu]])
        return np.asarray(solveh_banded(shifted, mu * y), dtype=float)

    return _calmest(solved, y, allowed)


def _calmest(solved: Callable[[float], Array], y: Array, allowed: float) -> Array:
    """Return the calmest s within the noise: its distance from y falls with the exponent."""
    calm, close = np.log(_LEAST), np.log(_MOST)
    for _ in range(_HALVINGS):
        middle = (calm + close) / 2
        if _rms(solved(middle) - y) > allowed:
            calm = middle
        else:
            close = middle
    return solved(close)


def _rms(values: Array) -> float:
    return float(np.sqrt((values**2).mean()))


def _with(samples: Samples, values: Array) -> Samples:
    slopes = slopes_of(samples.t, values) if samples.interpolation == "cubic" else samples.slopes
    return replace(samples, values=values, slopes=slopes)
