"""Singular values and eigenvalues of a product of many matrices that are known up to errors.

What the errors make of the result is found by trying: every factor is disturbed in all its entries, as much
as all K errors, and rounding, together could do if they pointed the same way, √K ε_k ‖C_k‖, some times over.
The largest change counts. Close eigenvalues move like roots of a disturbance, and so are judged rightly.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from obscli.numeric.matrix_product import groups, multiplied
from obscli.numeric.product_eigenvalues import Eigenvalue, product_eigenvalues
from obscli.numeric.product_gains import product_gains
from obscli.numeric.program import EPS, Array


_TRIES: Final = 4
_SEED: Final = 19_920_101


@dataclass(frozen=True, slots=True, eq=False)
class Spectrum:
    """Of C_K ⋯ C_1, the largest first, with errors relative to each.

    ``gains``: logarithms of the singular values (d,); ``right``: right singular vectors as rows (d, d);
    ``eigenvalues``: empty where they were not asked for.
    """

    gains: Array
    right: Array
    gain_errors: Array
    eigenvalues: tuple[Eigenvalue, ...]
    eigenvalue_errors: Array


def product_spectrum(factors: Sequence[Array], errors: Sequence[float], *, eigenvalues: bool) -> Spectrum:
    """Return singular values of C_K ⋯ C_1, and its eigenvalues where they are asked for.

    Parameters
    ----------
    factors : C_1 … C_K, shape (d, d) each
    errors : ε_k, relative to ‖C_k‖
    """
    ends = groups(factors)

    def found_of(some: Sequence[Array]) -> tuple[Array, Array, tuple[Eigenvalue, ...]]:
        product = multiplied(some, ends)
        return *product_gains(product), product_eigenvalues(product) if eigenvalues else ()

    gains, right, values = found_of(factors)
    gain_errors = np.full(len(gains), len(factors) * EPS)
    value_errors = np.array([len(factors) * EPS + one.error for one in values])
    for disturbed in _disturbed(factors, errors):
        others, _, other_values = found_of(disturbed)
        gain_errors = np.maximum(gain_errors, _relative(others - gains))
        value_errors = np.maximum(value_errors, _moved(values, other_values))
    return Spectrum(gains, right, gain_errors, values, value_errors)


def _disturbed(factors: Sequence[Array], errors: Sequence[float]) -> Iterator[list[Array]]:
    source = np.random.default_rng(_SEED)
    sizes = [
        np.sqrt(len(factors)) * (error + len(one) * EPS) * np.linalg.norm(one, 2)
        for one, error in zip(factors, errors, strict=True)
    ]
    for _ in range(_TRIES):
        yield [one + size * source.normal(size=one.shape) for one, size in zip(factors, sizes, strict=True)]


def _relative(difference: Array) -> Array:
    """Return |e^x − 1| for differences of logarithms."""
    return np.abs(np.expm1(np.clip(difference, -1.0, 1.0)))


def _moved(found: Sequence[Eigenvalue], others: Sequence[Eigenvalue]) -> Array:
    """Return how far eigenvalues are from those that take their places, relative to each."""
    left, moved = list(others), []
    for one in found:
        apart = [abs(_ratio(other, one) - 1) for other in left]
        nearest = int(np.argmin(apart))
        moved.append(apart[nearest])
        del left[nearest]
    return np.array(moved)


def _ratio(a: Eigenvalue, b: Eigenvalue) -> complex:
    return complex(np.exp(np.clip(a.log_modulus - b.log_modulus, -50.0, 50.0))) * a.phase / b.phase
