"""Singular values of the observability matrix at an instant, and what they say of its condition.

    M D = Σ σ_i u_i v_iᵀ

v_1 is the direction that shows most, v_r the one that shows least; n − r of them are zero. The condition is
σ_1/σ_n, ∞ below full rank; σ_1/σ_r on the observable subspace is given beside it.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from obscli.exact.ball import precision
from obscli.measures.local_spectrum import directions_of, local_spectrum
from obscli.measures.measure import Found, Measure, SystemValue
from obscli.measures.subject import Subject


def singular_values(subject: Subject) -> Found:
    """Return the singular values of M with their right vectors, and its condition numbers."""
    with precision(subject.local.bits, 1):
        found = directions_of(subject, local_spectrum(subject))
    values = [one.value for one in found[: subject.rank]]
    ratio = values[0] / values[-1] if values else np.inf
    system: dict[str, SystemValue] = {
        "singular-values": found,
        "condition-number": ratio if subject.rank == subject.n else np.inf,
        "condition-number-observable": ratio,
    }
    return Found(system=system)


SINGULAR_VALUES: Final = Measure(
    key="singular-values",
    symbol="σ",
    title="singular values of the observability matrix",
    reference="Ham & Brown 1983; Dong & Mo, (6)",
    reading="from the direction that shows most in outputs and derivatives to the one that shows least",
    compute=singular_values,
    basis="matrix",
)
