"""Eigenvalues and vectors of the normalised covariance: which directions the filter has learned.

    P' = P₀^(−½) P P₀^(−½),   P'' = n P' / tr P'

Eigenvalues between 0 and n: small ones belong to directions that are well observable, large ones to those
that are poorly observable; whether they are observable at all is another question.

References
----------
F. M. Ham, R. G. Brown, Observability, eigenvalues, and Kalman filtering (1983).
"""

from __future__ import annotations

from typing import Final

import numpy as np

from obscli.measures.measure import Direction, Found, Measure
from obscli.measures.subject import Subject


def normalised_covariance(subject: Subject) -> Found:
    """Return eigenvalues with their vectors in units of the prior's deviations, the smallest first."""
    first, after = subject.covariances.first, subject.covariances.last
    deviations = np.linalg.norm(first, axis=1)
    values, U = np.linalg.eigh(first @ first.T / np.outer(deviations, deviations))
    symmetric = U / np.sqrt(values) @ U.T / deviations
    left, sizes, _ = np.linalg.svd(symmetric @ after)
    squares = sizes**2 * subject.n / (sizes**2).sum()
    found = tuple(
        Direction(float(square), subject.named(vector))
        for square, vector in sorted(zip(squares, left.T, strict=True), key=lambda one: float(one[0]))
    )
    return Found(system={"normalised-covariance": found})


NORMALISED_COVARIANCE: Final = Measure(
    key="normalised-covariance",
    symbol="λ(P″)",
    title="eigenvalues of the normalised covariance",
    reference="Ham & Brown 1983",
    reading="small: a direction learned well; large: one that is not; in units of the prior's deviations",
    compute=normalised_covariance,
    basis="noise",
    scaled=False,
)
