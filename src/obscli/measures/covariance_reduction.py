"""The reduction of the covariance: what is left of the deviation of the prior.

    σ_i(t) / σ_i(t_0)

Above 1 where an error grows faster than it is learned.

References
----------
F. M. Ham, R. G. Brown (1983); the reciprocal is the degree of observability of some alignment filters.
"""

from __future__ import annotations

from typing import Final

from obscli.measures.measure import Found, Measure
from obscli.measures.subject import Subject


def covariance_reduction(subject: Subject) -> Found:
    """Return σ(t)/σ(t0) of every target; None where the prior leaves nothing open."""
    after, prior = subject.covariances.after[0], subject.covariances.prior
    return Found(tuple(float(a / b) if b > 0 else None for a, b in zip(after, prior, strict=True)))


COVARIANCE_REDUCTION: Final = Measure(
    key="covariance-reduction",
    symbol="σ/σ₀",
    title="covariance reduction",
    reference="Ham & Brown 1983",
    reading="what is left of the prior's deviation; 1: nothing was learned",
    compute=covariance_reduction,
    basis="noise",
    better="smaller",
    scaled=False,
)
