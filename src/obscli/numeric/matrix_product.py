"""A product of many matrices, C_K ⋯ C_1, to relative accuracy in all its directions.

Multiplied out, what shrinks by e^-40 drowns in the rounding of what does not. So the product is kept as

    C_K ⋯ C_1 V = Q diag(e^s) U,    Q orthogonal, U upper triangular, its rows of unit length

by one QR decomposition for each factor, C_k Q_{k-1} = Q_k R_k, and the rows of R_k ⋯ R_1 with their sizes as
logarithms. From a start V that leans towards what grows, s descends and U is well conditioned.

References
----------
G. W. Stewart, On graded QR decompositions of products of matrices, Electronic Transactions on Numerical
Analysis 3 (1995); L. Dieci, E. S. Van Vleck, SIAM Journal on Numerical Analysis 40 (2002).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from obscli.numeric.program import Array


#: Factors are multiplied out as long as their product is conditioned better than this, and of such a size.
_WELL_CONDITIONED: Final = 100.0
_SIZES: Final = (1e-100, 1e100)

_SEED: Final = 20_060_101


@dataclass(frozen=True, slots=True, eq=False)
class Graded:
    """Q diag(e^s) U: ``Q`` (d, d), ``s`` (d,), ``U`` (d, d)."""

    Q: Array
    s: Array
    U: Array


def graded(factors: Sequence[Array], start: Array) -> Graded:
    """Return C_K ⋯ C_1 V.

    Parameters
    ----------
    factors : C_1 … C_K, shape (d, d) each
    start : V, orthogonal, shape (d, d)
    """
    Q, s, U = start, np.zeros(len(start)), np.eye(len(start))
    for factor in factors:
        Q, R = np.linalg.qr(factor @ Q)
        s, U = _times(R, s, U)
    return Graded(Q, s, U)


def leaning(factors: Sequence[Array]) -> Array:
    """Return an orthogonal V whose first columns lean towards what C_K ⋯ C_1 makes largest."""
    return orthogonalised([one.T for one in reversed(factors)], arbitrary(len(factors[0])))


def orthogonalised(factors: Sequence[Array], V: Array) -> Array:
    """Return Q of C_K ⋯ C_1 V = Q R."""
    for factor in factors:
        V = np.linalg.qr(factor @ V)[0]
    return V


def arbitrary(d: int) -> Array:
    """Return an orthogonal matrix without special directions, always the same."""
    return np.linalg.qr(np.random.default_rng(_SEED).normal(size=(d, d)))[0]


def groups(factors: Sequence[Array]) -> tuple[int, ...]:
    """Return after how many factors to begin a new product, those between being well conditioned."""
    product, ends = np.eye(len(factors[0])), []
    for k, factor in enumerate(factors):
        product = factor @ product
        values = np.linalg.svd(product, compute_uv=False)
        fits = _SIZES[0] < values[0] < _SIZES[1] and values[0] < _WELL_CONDITIONED * values[-1]
        if not fits:
            product = factor
            ends.append(k)
    return (*[k for k in ends if k], len(factors))


def multiplied(factors: Sequence[Array], ends: Sequence[int]) -> list[Array]:
    """Return the products of the factors of each group."""
    found, first = [], 0
    for end in ends:
        product = factors[first]
        for factor in factors[first + 1 : end]:
            product = factor @ product
        found.append(product)
        first = end
    return found


def _times(R: Array, s: Array, U: Array) -> tuple[Array, Array]:
    """Return R diag(e^s) U as diag(e^s) U again."""
    with np.errstate(divide="ignore", under="ignore"):
        terms = np.log(np.abs(R)) + s
        largest = terms.max(axis=1)
        rows = (np.sign(R) * np.exp(terms - largest[:, None])) @ U
    size = np.linalg.norm(rows, axis=1)
    return largest + np.log(size), rows / size[:, None]
