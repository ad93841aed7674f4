"""Averages of squared normal numbers: χ² with so many degrees of freedom, divided by them."""

from __future__ import annotations

import numpy as np
from scipy.special import gammaincinv

from obscli.numeric.program import Array


def chi_squared_band(degrees: Array, confidence: float) -> tuple[Array, Array]:
    """Return the ends of the band that holds the average with a probability, as much on either side.

    Parameters
    ----------
    degrees : of freedom, shape (k,)
    confidence : from 0 to 1
    """
    shares = ((1 - confidence) / 2, (1 + confidence) / 2)
    lower, upper = (np.asarray(2 * gammaincinv(degrees / 2, one) / degrees, dtype=float) for one in shares)
    return lower, upper
