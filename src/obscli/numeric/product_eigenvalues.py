"""Eigenvalues of a product of many matrices, each to its own relative accuracy: Floquet multipliers.

Going through the factors again and again, V ← Q of C_K ⋯ C_1 V, turns V towards nested invariant subspaces.
Then with C_K ⋯ C_1 V = Q diag(e^s) U and M = Vᵀ Q, the product is V T Vᵀ,

    T = M diag(e^s) U,    M block diagonal where moduli differ

and the eigenvalues μ are those of the blocks. The eigenvector (x, y, 0) of one has

    M_bb e^{s_b} U_bb y = μ y,    (U_aa − μ e^{−s_a} M_aaᵀ) x = −U_ab y        a: the blocks before

References
----------
A. Bojanczyk, G. H. Golub, P. Van Dooren, The periodic Schur decomposition (1992).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from obscli.numeric.matrix_product import arbitrary, graded, orthogonalised
from obscli.numeric.program import EPS, Array


#: So many times at the most, and no more when all factors together were used so often.
_PASSES: Final = 80
_FEWEST_PASSES: Final = 4
_FACTORS: Final = 2000

#: What is left below a block is left out where it is smaller than this; so many times that is the error.
_SPLIT: Final = 1e-11
_LEFT_OUT: Final = 10.0

Complex: TypeAlias = NDArray[np.complex128]


@dataclass(frozen=True, slots=True, eq=False)
class Eigenvalue:
    """e^log_modulus times ``phase`` of modulus 1.

    ``vector``: its eigenvector, shape (d,); ``error``: by what the algorithm leaves out and rounds, relative.
    """

    log_modulus: float
    phase: complex
    vector: Complex
    error: float


def product_eigenvalues(factors: Sequence[Array]) -> tuple[Eigenvalue, ...]:
    """Return the eigenvalues of C_K ⋯ C_1, the largest first."""
    V = arbitrary(len(factors[0]))
    passes = max(_FEWEST_PASSES, min(_PASSES, _FACTORS // len(factors)))
    below = np.full(len(V), np.inf)
    for _ in range(passes):
        before, V = V, orthogonalised(factors, V)
        last, below = below, _below(before.T @ V)
        if (below <= _SPLIT).all() and (below >= last / 2).all():
            break
    product = graded(factors, V)
    M = V.T @ product.Q
    below = _below(M)
    starts = np.flatnonzero(below <= _SPLIT).tolist()
    found = [
        one
        for first, end in zip(starts, [*starts[1:], len(M)], strict=True)
        for one in _of_block(M, product.s, product.U, first, end)
    ]
    left_out = _LEFT_OUT * float(below[starts].max())
    found = [replace(one, vector=V @ one.vector, error=one.error + left_out) for one in found]
    return tuple(sorted(found, key=lambda one: (-one.log_modulus, one.phase.imag < 0)))


def _below(M: Array) -> Array:
    """Return the largest entry below and before each place on the diagonal, shape (d,)."""
    return np.array([np.abs(M[k:, :k]).max(initial=0.0) for k in range(len(M))])


def _of_block(M: Array, s: Array, U: Array, first: int, end: int) -> Iterator[Eigenvalue]:
    """Yield the eigenvalues of one block of T = M diag(e^s) U, with eigenvectors of T."""
    a, b = slice(0, first), slice(first, end)
    largest = s[b].max()
    block = (M[b, b] * np.exp(s[b] - largest)) @ U[b, b]
    values, vectors = np.linalg.eig(block)
    for value, y, error in zip(values, vectors.T, _rounding(block, values, vectors), strict=True):
        modulus = abs(value)
        size, phase = float(largest + np.log(modulus)), complex(value / modulus)
        before = U[a, a] - phase * np.exp(size - s[a])[:, None] * M[a, a].T
        x = np.linalg.solve(before, -U[a, b] @ y[:, None])[:, 0]
        vector = np.concatenate([x, y, np.zeros(len(s) - end)])
        yield Eigenvalue(size, phase, vector / np.linalg.norm(vector), float(error))


def _rounding(block: Array, values: Complex, vectors: Complex) -> Array:
    """Return how far rounding moves eigenvalues of a matrix, relative to each.

    To first order ε‖B‖ over the angle of left and right eigenvectors, but no more than ‖B‖ε^(1/k) (Elsner).
    """
    size, k = np.linalg.norm(block, 2), len(block)
    rounding = k * EPS
    try:
        condition = np.linalg.norm(np.linalg.inv(vectors), axis=1)
    except np.linalg.LinAlgError:
        condition = np.full(k, np.inf)
    moved: Array = np.minimum(rounding * condition, rounding ** (1 / k)) * size / np.abs(values)
    return moved
