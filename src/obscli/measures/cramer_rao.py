"""The Cramér–Rao bound: the smallest deviation that the samples alone allow, without a prior.

    σ_i ≥ √(c J⁻¹ cᵀ),   J = Σ Φᵀ Hᵀ R⁻¹ H Φ   (driving noise: the information that it leaves)

Infinite exactly where the target is not observable.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from obscli.measures.covariances import bounds_at
from obscli.measures.measure import Found, Measure, NotMeasuredError
from obscli.measures.subject import Subject


def cramer_rao(subject: Subject) -> Found:
    """Return the bound of every target, in the file's units."""
    bounds = bounds_at(subject, np.array([subject.at]))[0]
    if np.isnan(bounds).any():
        raise NotMeasuredError(
            f"the samples up to {subject.at:.6g} do not tell all observable combinations apart: take a later "
            "instant (--at), or more samples (--step)"
        )
    return Found(tuple(float(one) for one in bounds))


CRAMER_RAO: Final = Measure(
    key="cramer-rao",
    symbol="CRB",
    title="Cramér–Rao bound",
    reference="Cramér 1946; Rao 1945",
    reading="the smallest deviation from the samples alone, in the unit of the state; inf: not observable",
    compute=cramer_rao,
    basis="noise",
    better="smaller",
    scaled=False,
)
