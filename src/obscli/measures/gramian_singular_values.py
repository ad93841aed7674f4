"""Eigenvalues of the observability Gramian over the interval, with their directions.

    W(t, t_0) = ∫ Φᵀ Hᵀ H Φ dτ = Rᵀ R,   λ_i = σ_i(R)²

Of a discrete-time system W is the sum over the samples, and v_i are directions at the start.

The outputs' energy from a state along v_i is λ_i. n − r of them are zero, known exactly; of the others those
below the error of R have no value.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from obscli.measures.measure import Direction, Found, Measure, NotMeasuredError
from obscli.measures.subject import Subject
from obscli.numeric.analysis import affordable_steps
from obscli.numeric.discrete_gramian import discrete_gramian
from obscli.numeric.gramian import Gramian
from obscli.numeric.rates import rates_of
from obscli.numeric.settings import STEP_ERROR, Effort
from obscli.numeric.square_root import square_root_gramian


def gramian_singular_values(subject: Subject) -> Found:
    """Return the eigenvalues of W with their vectors, the largest first."""
    numeric = subject.numeric
    if subject.system.discrete:
        return _found(subject, discrete_gramian(numeric, np.array([subject.start]), subject.at))
    if subject.at <= subject.start:
        raise NotMeasuredError("the Gramian over no time at all is zero: choose a later instant (--at)")
    rates = rates_of(numeric, np.linspace(subject.start, subject.at, 18)[1:-1])
    effort = Effort(STEP_ERROR["square-root"], affordable_steps(numeric))
    return _found(subject, square_root_gramian(numeric, subject.start, np.array([subject.at]), rates, effort))


def _found(subject: Subject, gramian: Gramian) -> Found:
    """Return the eigenvalues of one Gramian."""
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
