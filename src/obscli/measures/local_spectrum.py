"""Singular values and vectors of what a subject shows: of M(t), or of the Gramian's square root."""

from __future__ import annotations

import numpy as np

from obscli.exact.ball import precision
from obscli.measures.gram_spectrum import GramSpectrum, gram_spectrum
from obscli.measures.measure import Direction
from obscli.measures.subject import Subject


def local_spectrum(subject: Subject) -> GramSpectrum:
    """Return the singular values and vectors of M(t); use inside ``precision``."""
    return gram_spectrum(subject.local.orthogonal.C, subject.local.orthogonal.U)


def directions_of(subject: Subject, spectrum: GramSpectrum) -> tuple[Direction, ...]:
    """Return singular values with their right vectors, the largest first, zeros without."""
    found = [
        Direction(value, subject.named(np.array(spectrum.right_vector(i))))
        for i, value in enumerate(spectrum.values)
    ]
    return (*found, *(Direction(0.0, {}) for _ in range(subject.n - len(found))))


def root_of_gram(subject: Subject) -> list[float]:
    """Return the diagonal of (MᵀM)^½, one number a state."""
    with precision(subject.local.bits, 1):
        spectrum = local_spectrum(subject)
        U = spectrum.U
        half = spectrum.function(tuple(one.sqrt() for one in spectrum.squares))
        root = U.transpose() * half * U if subject.rank else None
        return [0.0 if root is None else float(root[k, k]) for k in range(subject.n)]
