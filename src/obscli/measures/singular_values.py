"""Singular values of the observability matrix at an instant, and what they say of its condition.

    M D = Σ σ_i u_i v_iᵀ

v_1 is the direction that shows most, v_r the one that shows least; n − r of them are zero. The condition is
σ_1/σ_n, ∞ below full rank; σ_1/σ_r on the observable subspace is given beside it,
as its logarithm where double precision does not hold it.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from flint import arb

from obscli.exact.ball import precision
from obscli.measures.in_range import as_double, beyond, or_nan
from obscli.measures.local_spectrum import directions_of, local_spectrum
from obscli.measures.measure import Found, Measure, SystemValue
from obscli.measures.subject import Subject


def singular_values(subject: Subject) -> Found:
    """Return the singular values of M with their right vectors, and its condition numbers."""
    with precision(subject.local.bits, 1):
        spectrum = local_spectrum(subject)
        found = directions_of(subject, spectrum)
        condition = spectrum.condition
        ratio = or_nan(as_double(condition)) if subject.rank else np.inf
        logarithm = float(condition.log() / arb(10).log())
    system: dict[str, SystemValue] = {
        "singular-values": found,
        "condition-number": ratio if subject.rank == subject.n else np.inf,
        "condition-number-observable": ratio,
    }
    if np.isnan(ratio):
        system["condition-number-observable-log10"] = logarithm
    lost = beyond(spectrum.values.count(None), "singular value")
    return Found(system=system, remarks=(*lost, *beyond(int(np.isnan(ratio)), "condition number")))


SINGULAR_VALUES: Final = Measure(
    key="singular-values",
    symbol="σ",
    title="singular values of the observability matrix",
    reference="Ham & Brown 1983; Dong & Mo, (6)",
    reading="from the direction that shows most in outputs and derivatives to the one that shows least",
    compute=singular_values,
    basis="matrix",
)
