"""The stochastic measure: what share of the uncertainty the measurements take away.

    μ_i(t) = 1 − √(p⁺_i / p⁻_i)

p⁺ the variance of the Kalman filter, p⁻ that of the same error had nothing been measured (open loop). A state
that is not observable does not get 0: a prior that correlates it with others, or makes them likelier than it,
teaches something of it too. So the verdict stands beside the number.

References
----------
I. A. Bagmut (2009), (4), after N. A. Parusnikov; p⁻, which is not defined there, as above.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from obscli.measures.covariances import shares
from obscli.measures.measure import Found, Measure
from obscli.measures.subject import Subject


def stochastic(subject: Subject) -> Found:
    """Return 1 − σ⁺/σ⁻ of every target; None where nothing is uncertain without measurements."""
    values = shares(subject.covariances)[0]
    return Found(tuple(None if np.isnan(value) else float(value) for value in values))


STOCHASTIC: Final = Measure(
    key="stochastic",
    symbol="(4)",
    title="stochastic",
    reference="Bagmut 2009, (4); Parusnikov",
    reading="the share of the deviation, compared with no measurements, that the filter takes away; up to 1",
    compute=stochastic,
    basis="noise",
    better="larger",
    scaled=False,
)
