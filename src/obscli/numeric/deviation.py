"""Standard deviations from square roots of information: σ(c) = |c S⁺|, infinite where S does not see c."""

from __future__ import annotations

from typing import Final

import numpy as np

from obscli.numeric.program import Array


#: In units in which the columns of S have length 1: a smaller singular value is none, a larger leak is one.
_ZERO: Final = 1e-11
_LEAK: Final = 1e-5


def deviations(root: Array, covectors: Array) -> Array:
    """Return the standard deviation of linear forms, shape (k,).

    Parameters
    ----------
    root : rows S with Sᵀ S the information, shape (r, n)
    covectors : shape (k, n)
    """
    size = np.linalg.norm(root, axis=0)
    seen = size > 0
    units = np.where(seen, size, 1.0)
    scaled = covectors / units
    triangle = np.linalg.qr(root / units, mode="r") if len(root) else np.zeros((0, root.shape[1]))
    _, values, right = np.linalg.svd(triangle)
    values = np.concatenate([values, np.zeros(root.shape[1] - len(values))])
    known = values > _ZERO * values.max(initial=0.0)
    along = scaled @ right.T
    leak = np.linalg.norm(along[:, ~known], axis=1)
    found = np.linalg.norm(along[:, known] / values[known], axis=1)
    hidden = leak > _LEAK * np.linalg.norm(scaled, axis=1)
    # a column of zeros has no unit of its own: any component along it is unseen
    unseen = (covectors[:, ~seen] != 0).any(axis=1)
    deviation: Array = np.where(hidden | unseen, np.inf, found)
    return deviation
