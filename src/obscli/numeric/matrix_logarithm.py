"""The real logarithm of a matrix without eigenvalues on the negative real axis, all in real arithmetic.

Inverse scaling and squaring: log A = 2^k log A^(1/2^k), the roots by the product form of Denman and Beavers'
iteration, and near the identity, with Gauss–Legendre nodes x_j and weights w_j (a Padé approximant),

    log(I + E) = ∫_0^1 E (I + x E)⁻¹ dx = Σ_j w_j E (I + x_j E)⁻¹

Each root costs a bit of what is known of A − I: a few for a balanced matrix (determinant of modulus 1).

References
----------
N. J. Higham, Functions of Matrices (2008), 6.3 and 11.4–11.5.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from obscli.numeric.collocation import gauss_legendre
from obscli.numeric.errors import NotComputableError
from obscli.numeric.program import EPS, Array


#: The approximant is exact to rounding for ‖E‖ below this with so many nodes.
_NEAR: Final = 0.25
_NODES: Final = 9

_ROOTS: Final = 60
_ITERATIONS: Final = 60


def real_logarithm(A: Array) -> Array:
    """Return the principal logarithm of A, real, shape (d, d): eigenvalues with imaginary parts within ±π.

    Raises
    ------
    NotComputableError
        where A is singular, or has an eigenvalue on the negative real axis, but for rounding
    """
    root, k = A, 0
    while not np.linalg.norm(root - np.eye(len(A))) < _NEAR:
        if k == _ROOTS:
            raise NotComputableError("the roots of the matrix do not approach the identity")
        root, k = square_root(root), k + 1
    found: Array = 2.0**k * _near_identity(root)
    return found


def _near_identity(A: Array) -> Array:
    """Return log A where ‖A − I‖ is small."""
    rule, identity = gauss_legendre(_NODES), np.eye(len(A))
    E = A - identity
    terms = np.linalg.solve(identity + rule.nodes[:, None, None] * E, np.broadcast_to(E, (_NODES, *E.shape)))
    return np.asarray(np.tensordot(rule.weights, terms, 1), dtype=float)


def square_root(A: Array) -> Array:
    """Return the principal square root of A, real, shape (d, d).

    X ← μ X (I + μ⁻² M⁻¹)/2,    M ← (I + (μ² M + μ⁻² M⁻¹)/2)/2,    from X = M = A, where M → I

    Raises
    ------
    NotComputableError
        where A is singular, or has an eigenvalue on the negative real axis, but for rounding
    """
    d, identity = len(A), np.eye(len(A))
    X = M = A
    apart = np.inf
    for _ in range(_ITERATIONS):
        sign, size = np.linalg.slogdet(M)
        if not (sign > 0 and np.isfinite(size)):
            break
        # once M is near I, scaling only stirs up rounding
        mu = np.exp(-size / (2 * d)) if apart > _NEAR else 1.0
        inverse = np.linalg.inv(M) / mu**2
        X, M = mu * X @ (identity + inverse) / 2, (identity + (mu**2 * M + inverse) / 2) / 2
        last, apart = apart, float(np.linalg.norm(M - identity))
        if apart <= d * EPS or (apart < _NEAR and apart >= last / 2):
            return np.asarray(X, dtype=float)
    raise NotComputableError("a matrix with an eigenvalue on the negative real axis has no real square root")
