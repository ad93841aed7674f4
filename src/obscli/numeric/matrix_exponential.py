"""Transition matrices of many frozen systems over one step, exp(A h), all at once.

    exp(X) = (Σ_{k ≤ 14} (X/2^s)^k/k!)^(2^s),    2^(−s) max(|X²|^½, |X³|^⅓) ≤ ½

The remainder of the series is bounded by these roots of powers, not by |X|: units far apart cost no
squarings, and each squaring costs digits. Only the moving states' rows are kept; the others are those of I.

References
----------
A. H. Al-Mohy, N. J. Higham, A new scaling and squaring algorithm for the matrix exponential, 2009.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from obscli.numeric.program import Array
from obscli.numeric.transition import times


_TERMS: Final = 14
_LARGEST: Final = 0.5


def exponentials(A: Array, moving: Array, h: float | Array) -> Array:
    """Return the moving rows of exp(A h).

    Parameters
    ----------
    A : moving rows, shape (k, p, n)
    moving : which rows they are, shape (p,)
    h : the step, one for all or one for each

    Returns
    -------
    shape (k, p, n)
    """
    X = np.broadcast_to(np.asarray(h, dtype=float), (len(A),))[:, None, None] * A
    squarings = _squarings(X, moving)
    X = X / 2.0**squarings
    identity = np.eye(A.shape[2])[moving]
    # Horner, the identity added last: I + X (I + X/2 (I + …))
    found: Array = identity + X / _TERMS
    for k in range(_TERMS - 1, 0, -1):
        found = identity + times(X, found, moving) / k
    for _ in range(squarings):
        found = times(found, found, moving)
    return found


def _squarings(X: Array, moving: Array) -> int:
    """Return s, one for all."""
    core = X[..., moving]
    second = core @ core
    third = second @ core
    size = max(_norm(second) ** (1 / 2), _norm(third) ** (1 / 3))
    return max(0, int(np.ceil(np.log2(size / _LARGEST)))) if size > _LARGEST else 0


def _norm(X: Array) -> float:
    return float(np.abs(X).sum(axis=2).max(initial=0.0))
