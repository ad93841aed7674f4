"""Eigenvalues of the observability Gramian over the interval, with their directions.

    W(t, t_0) = ∫ Φᵀ Hᵀ H Φ dτ = Rᵀ R,   λ_i = σ_i(R)²

The outputs' energy from a state along v_i is λ_i. n − r of them are zero, known exactly; of the others those
below the error of R have no value.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from obscli.measures.measure import Direction, Found, Measure, NotMeasuredError
from obscli.measures.subject import Subject


def gramian_singular_values(subject: Subject) -> Found:
    """Return the eigenvalues of W with their vectors, the largest first."""
    if subject.at <= subject.start:
        raise NotMeasuredError("the Gramian over no time at all is zero: choose a later instant (--at)")
    gramian = subject.gramian
    factors = (subject.units / gramian.units[0])[None]
    scaled = gramian.in_units(factors)
    _, values, right = np.linalg.svd(scaled.matrices[0])
    found = []
    for k, (value, v) in enumerate(zip(values, right, strict=True)):
        wrong = float(np.sqrt(max(v @ scaled.error[0] @ v, 0.0)))
        known = k < subject.rank and value > wrong
        found.append(Direction(float(value**2) if known else 0.0 if k >= subject.rank else np.nan, {}))
        if known:
            found[-1] = Direction(float(value**2), subject.named(v))
    lost = sum(np.isnan(one.value) for one in found)
    remark = f"{lost} eigenvalues of the Gramian are below its error" if lost else ""
    return Found(system={"gramian-singular-values": tuple(found)}, remarks=(remark,) if lost else ())


GRAMIAN_SINGULAR_VALUES: Final = Measure(
    key="gramian-singular-values",
    symbol="λ(W)",
    title="singular values of the Gramian",
    reference="Kalman 1960",
    reading="the energy in the outputs from a unit of each direction over the interval",
    compute=gramian_singular_values,
    basis="samples",
)
