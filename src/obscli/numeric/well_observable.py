"""How well states are observable at the samples of a filter: σ̃ of the window that starts there.

σ̃ is the equivalent singular value (``window_measures``) of the next n instants at which something is sampled,
the first included, A and H as they are at the first, in units of P0 and of the noise:

    R = [W_0 H; W_1 H Φ(t_1 − t_0); …] D,    Φ(h) = exp(A h), or F^h,    σ̃_k = [(RᵀR)^½]_kk

The last windows have the pattern of the last one that is whole. Of a filter's model all is known beforehand.

References
----------
Dong Jinlong, Mo Bo: only states that are well observable are to be fed back.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from obscli.numeric.matrix_exponential import exponentials
from obscli.numeric.numeric_system import Coefficients
from obscli.numeric.program import Array
from obscli.numeric.sampled_system import SampledSystem


#: Numbers (of 8 bytes) of one stack held at a time.
_CHUNK: Final = 1_000_000


def equivalent_at_samples(sampled: SampledSystem) -> Array:
    """Return σ̃ of every state in the window that starts at each sample, shape (samples, n).

    Raises
    ------
    NotComputableError
        where a coefficient does not exist at some sample
    """
    numeric, t = sampled.numeric, sampled.schedule.t
    n, length = numeric.n, min(numeric.n, len(t))
    deviations = np.sqrt(np.diag(sampled.noise.P0))
    found = np.empty((len(t), n))
    portion = max(_CHUNK // (length * numeric.m * n), 1)
    for first in range(0, len(t), portion):
        starts = np.arange(first, min(first + portion, len(t)))
        window = np.minimum(starts, len(t) - length)[:, None] + np.arange(length)
        coefficients = numeric.coefficients(t[starts])
        rows = np.empty((len(starts), length, numeric.m, n))
        phi = np.broadcast_to(np.eye(n), (len(starts), n, n))
        for j in range(length):
            if j:
                phi = _moved(sampled, coefficients, t[window[:, j]] - t[window[:, j - 1]]) @ phi
            rows[:, j] = sampled.whitening(window[:, j]) @ coefficients.H @ phi * deviations
        _, values, right = np.linalg.svd(
            rows.reshape(len(starts), length * numeric.m, n), full_matrices=False
        )
        found[starts] = np.einsum("kij,ki->kj", right**2, values)
    return found


def _moved(sampled: SampledSystem, coefficients: Coefficients, steps: Array) -> Array:
    """Return Φ over a step each, A kept, shape (k, n, n)."""
    numeric = sampled.numeric
    if numeric.system.discrete:
        whole = np.round(steps).astype(int)
        return np.array([np.linalg.matrix_power(F, h) for F, h in zip(coefficients.A, whole, strict=True)])
    found = np.tile(np.eye(numeric.n), (len(steps), 1, 1))
    found[:, numeric.moving] = exponentials(coefficients.A, numeric.moving, steps)
    return found
