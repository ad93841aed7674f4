"""The invariant subspaces of a periodic system, one for each group of Floquet multipliers of like modulus.

With Q_k R_k = C_k Q_{k−1} from nested invariant subspaces Q_0, after a period Q_K = Q_0 M, M block diagonal.
The subspace of the diagonal block b, with the blocks a before it (which grow faster), has the basis

    B_k = Q_k (x_k, I, 0)ᵀ,    C_k B_{k−1} = B_k (R_k)_bb,    (R_k)_aa x_{k−1} = x_k (R_k)_bb − (R_k)_ab
    x_K = M_aaᵀ x_0 M_bb

Backwards, what grows faster dies out faster: passing through the period again and again, x comes to rest.
So each group is followed without drowning in the rounding of those that grow more.

References
----------
A. Bojanczyk, G. H. Golub, P. Van Dooren, The periodic Schur decomposition (1992).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from obscli.numeric.matrix_product import arbitrary, orthogonalised
from obscli.numeric.program import EPS, Array


#: Moduli that differ by less than this factor, one after the other, belong to one group.
_LIKE: Final = float(np.log(30.0))

_PASSES: Final = 60
_SPLIT: Final = 1e-15


@dataclass(frozen=True, slots=True, eq=False)
class PeriodicSubspace:
    """B_0 … B_{K−1}, ``bases`` (K, n, d), and ``steps`` S_k (K, d, d): C_k B_{k−1} = B_k S_k, B_K = B_0."""

    bases: Array
    steps: Array


def groups_of(log_moduli: Sequence[float]) -> tuple[slice, ...]:
    """Return the groups of multipliers of like modulus.

    Parameters
    ----------
    log_moduli : logarithms of the moduli, the largest first
    """
    firsts = [k for k in range(len(log_moduli)) if not k or log_moduli[k - 1] - log_moduli[k] > _LIKE]
    return tuple(slice(a, b) for a, b in zip(firsts, [*firsts[1:], len(log_moduli)], strict=True))


def periodic_subspaces(factors: Sequence[Array], groups: Sequence[slice]) -> list[PeriodicSubspace]:
    """Return the invariant subspaces of C_K ⋯ C_1, one for each group.

    Parameters
    ----------
    factors : C_1 … C_K, shape (n, n) each
    groups : places in the order of moduli, the largest first
    """
    V = _nested(factors, [one.start for one in groups[1:]])
    Q, R = [V], []
    for factor in factors:
        next_Q, next_R = np.linalg.qr(factor @ Q[-1])
        Q.append(next_Q)
        R.append(next_R)
    M = V.T @ Q[-1]
    return [_subspace(Q, R, M, one) for one in groups]


def _nested(factors: Sequence[Array], splits: Sequence[int]) -> Array:
    """Return an orthogonal V whose first columns up to each split span an invariant subspace, (n, n)."""
    V, below = arbitrary(len(factors[0])), np.inf
    for _ in range(_PASSES):
        before, V = V, orthogonalised(factors, V)
        M = before.T @ V
        last, below = below, max((float(np.abs(M[k:, :k]).max()) for k in splits), default=0.0)
        if below <= _SPLIT or (below < np.sqrt(EPS) and below >= last / 2):
            break
    return V


def _subspace(Q: Sequence[Array], R: Sequence[Array], M: Array, group: slice) -> PeriodicSubspace:
    a, b = slice(0, group.start), group
    steps = np.array([one[b, b] for one in R])
    x = [np.zeros((group.start, group.stop - group.start))] * len(Q)
    for _ in range(_PASSES):
        last, x = x[0], _backward(R, M[a, a].T @ x[0] @ M[b, b], a, b)
        if np.abs(x[0] - last).max(initial=0.0) <= EPS * np.abs(x[0]).max(initial=0.0):
            break
    steps[-1] = M[b, b] @ steps[-1]
    bases = np.array([one[:, a] @ there + one[:, b] for one, there in zip(Q[:-1], x[:-1], strict=True)])
    return PeriodicSubspace(bases, steps)


def _backward(R: Sequence[Array], last: Array, a: slice, b: slice) -> list[Array]:
    """Return x_0 … x_K from x_K."""
    x = [last]
    for one in reversed(R):
        x.append(np.asarray(np.linalg.solve(one[a, a], x[-1] @ one[b, b] - one[a, b]), dtype=float))
    return x[::-1]
