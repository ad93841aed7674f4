"""Eigenvalues of the observability Gramian over the interval, with their directions.

    W(t, t_0) = ∫ Φᵀ Hᵀ H Φ dτ = Rᵀ R,   λ_i = σ_i(R)²

Of a discrete-time system W is the sum over the samples, and v_i are directions at the start; of segments of
one they are directions at the end.

The outputs' energy from a state along v_i is λ_i. n − r of them are zero, known exactly; of the others those
that the error of R leaves without four digits have no value.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from obscli.measures.in_range import as_double
from obscli.measures.measure import Direction, Found, Measure, NotMeasuredError
from obscli.measures.root_spectrum import RootSpectrum, root_spectrum
from obscli.measures.subject import Subject


#: Singular values whose relative error is below this have four digits, and their squares.
_KNOWN: Final = 5e-5


def gramian_singular_values(subject: Subject) -> Found:
    """Return the eigenvalues of W with their vectors, the largest first."""
    if subject.at <= subject.start and not subject.system.discrete:
        raise NotMeasuredError("the Gramian over no time at all is zero: choose a later instant (--at)")
    gramian = subject.gramian
    spectrum = root_spectrum(
        gramian.matrices[0], gramian.error[0], subject.units / gramian.units[0], subject.rank
    )
    found = [_direction(subject, spectrum, i) for i in range(subject.rank)]
    lost = sum(np.isnan(one.value) for one in found)
    zeros = [Direction(0.0, {})] * (subject.n - subject.rank)
    return Found(system={"gramian-singular-values": (*found, *zeros)}, remarks=_remarks(lost))


def _direction(subject: Subject, spectrum: RootSpectrum, i: int) -> Direction:
    value = as_double(spectrum.squares[i]) if spectrum.wrong[i] < _KNOWN else None
    if not value:
        return Direction(np.nan, {})
    return Direction(value, subject.named(np.array([float(one) for one in spectrum.vectors[i]])))


def _remarks(lost: int) -> tuple[str, ...]:
    if not lost:
        return ()
    many = f"{lost} eigenvalues of the Gramian are" if lost > 1 else "an eigenvalue of the Gramian is"
    return (f"{many} not known to four digits, or beyond the range of double precision",)


GRAMIAN_SINGULAR_VALUES: Final = Measure(
    key="gramian-singular-values",
    symbol="λ(W)",
    title="singular values of the Gramian",
    reference="Kalman 1960",
    reading="the energy in the outputs from a unit of each direction over the interval",
    compute=gramian_singular_values,
    basis="samples",
)
