"""Singular values and vectors of what a subject shows: of M(t), or of the Gramian's square root."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from obscli.exact.ball import precision
from obscli.measures.gram_spectrum import GramSpectrum, gram_spectrum
from obscli.measures.in_range import as_double, or_nan
from obscli.measures.local import Local
from obscli.measures.measure import Direction
from obscli.measures.subject import Subject


def local_spectrum(subject: Subject) -> GramSpectrum:
    """Return the singular values and vectors of M(t), to the precision of its rows."""
    return _spectrum(subject.local)


@lru_cache(maxsize=2)  # several measures of one subject rest on it
def _spectrum(there: Local) -> GramSpectrum:
    with precision(there.bits, 1):
        return gram_spectrum(there.orthogonal.C, there.orthogonal.U)


def directions_of(subject: Subject, spectrum: GramSpectrum) -> tuple[Direction, ...]:
    """Return singular values with their right vectors, the largest first, zeros without.

    Use inside ``precision``. A singular value beyond double precision is not a number.
    """
    found = [
        Direction(or_nan(value), subject.named(np.array([float(one) for one in spectrum.right_vector(i)])))
        for i, value in enumerate(spectrum.values)
    ]
    return (*found, *(Direction(0.0, {}) for _ in range(subject.n - len(found))))


def root_of_gram(subject: Subject) -> list[float | None]:
    """Return the diagonal of (MᵀM)^½, one number a state, None where it is beyond double precision."""
    with precision(subject.local.bits, 1):
        spectrum = local_spectrum(subject)
        U = spectrum.U
        half = spectrum.function(tuple(one.sqrt() for one in spectrum.squares))
        root = U.transpose() * half * U if subject.rank else None
        return [0.0 if root is None else as_double(root[k, k]) for k in range(subject.n)]
