"""The standard deviation of the Kalman filter's error at the instant, from the prior of the file.

σ_i(t) = √(c P⁺(t) cᵀ)
"""

from __future__ import annotations

from typing import Final

from obscli.measures.measure import Found, Measure
from obscli.measures.subject import Subject


def standard_deviation(subject: Subject) -> Found:
    """Return σ of every target, in the file's units."""
    return Found(tuple(float(one) for one in subject.covariances.after[0]))


STANDARD_DEVIATION: Final = Measure(
    key="standard-deviation",
    symbol="σ(t)",
    title="standard deviation",
    reference="Kalman 1960",
    reading="of the filter's error, from the prior of the file, in the unit of the state",
    compute=standard_deviation,
    basis="noise",
    better="smaller",
    scaled=False,
)
