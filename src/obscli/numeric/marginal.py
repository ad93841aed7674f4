"""The square root of the information on some states while the others are unknown, and several of them joined.

For M = (F C), columns of the unknown states first, N an orthonormal basis of the left kernel of F:

    S = Nᵀ C,    Sᵀ S = Cᵀ C − Cᵀ F (Fᵀ F)⁺ Fᵀ C    (the Schur complement)

S v is what remains of M (f, v) for the best f = −F⁺ C v; so to first order the error of M is seen through
T = (−F⁺ C; I):  |ΔS v|² ≲ vᵀ Tᵀ E T v.  Which directions of F are noise is decided as for the rank.

Runs in which the same states are shared and the others start anew add up: S = (S_1; …; S_k).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from obscli.numeric.gramian import LOST, Gramian, squared_rounding
from obscli.numeric.program import EPS, Array, Counts
from obscli.numeric.subspace import CLEAR, TOLERANCE, Subspaces


@dataclass(frozen=True, slots=True, eq=False)
class Marginal:
    """S (r, c) in the file's units, |ΔS v|² ≲ vᵀ E v.

    ``decided``: no direction of F is in the grey zone; ``dropped``: how many were taken as not seen at all.
    One of these that is seen after all, below rounding, would take a row from S.
    """

    root: Array
    error: Array
    decided: bool
    dropped: int


def marginal(spaces: Subspaces, i: int, kept: Counts) -> Marginal:
    """Return the information on the states ``kept`` at one instant, the others unknown.

    Parameters
    ----------
    spaces : the decomposed square root of a Gramian
    i : the instant
    kept : indices of the states kept, shape (c,)
    """
    unknown = np.setdiff1d(np.arange(spaces.n), kept)
    units = spaces.gramian.units[i]
    matrix = spaces.values[i][:, None] * spaces.right[i]
    error = spaces.gramian.error[i]
    F, C = matrix[:, unknown], matrix[:, kept]
    F[:, ~spaces.gramian.matrices[i][:, unknown].any(axis=0)] = 0.0  # not rounding of the decomposition
    left, values, right = np.linalg.svd(F)
    along = np.einsum("kj,jl,kl->k", right, error[np.ix_(unknown, unknown)], right)
    noise = np.sqrt(np.maximum(along[::-1].cumsum()[::-1], 0.0)) + EPS * values.max(initial=0.0)
    clear = np.logical_and.accumulate(values > TOLERANCE * noise)
    r = int(clear.sum())
    inverse = right[:r].T @ ((left[:, :r].T @ C) / values[:r, None])
    T = np.zeros((spaces.n, len(kept)))
    T[kept], T[unknown] = np.eye(len(kept)), -inverse
    through = T.T @ error @ T
    size = (
        np.linalg.norm(C, axis=0) ** 2 + np.linalg.norm(values[:r, None] * (right[:r] @ inverse), axis=0) ** 2
    )
    through.flat[:: len(kept) + 1] += squared_rounding(spaces.n) * size
    scale = 1 / units[kept]
    return Marginal(
        (left[:, r:].T @ C) * scale,
        through * scale * scale[:, None],
        bool(r == 0 or values[r - 1] >= CLEAR * TOLERANCE * noise[r - 1]),
        int((F != 0).any(axis=0).sum()) - r,
    )


def joined(labels: Array, parts: Sequence[Sequence[Marginal]]) -> Gramian:
    """Return the square roots of sums of information as a Gramian over the kept states.

    Parameters
    ----------
    labels : what stands for the instants, shape (N,)
    parts : for each of them what is added up
    """
    n = parts[0][0].root.shape[1]
    matrices, error = np.zeros((len(parts), n, n)), np.zeros((len(parts), n, n))
    for k, group in enumerate(parts):
        rows = np.concatenate([one.root for one in group])
        triangle = np.linalg.qr(rows, mode="r")
        matrices[k, : len(triangle)] = triangle
        error[k] = sum(one.error for one in group)
        if not all(one.decided for one in group):  # what was eliminated may be less, or more
            error[k] = LOST * np.eye(n)
        error[k].flat[:: n + 1] += squared_rounding(n) * (rows**2).sum(axis=0)
    zeros, ones = np.zeros(len(parts)), np.ones((len(parts), n))
    return Gramian("square-root", labels, zeros, matrices, ones, error, zeros)
