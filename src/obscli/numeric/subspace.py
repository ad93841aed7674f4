"""Rank, gap and kernel of the Gramian at every instant, decided against what is known of its error.

With M = U Σ Vᵀ in scaled units and the error |ΔM v|² ≲ vᵀ E v, the noise along the last right singular
vectors, ν_k² = Σ_{j ≥ k} v_jᵀ E v_j, is what their singular values may have been moved by:

    q = #{ k : σ_k ≤ 10 ν_k },    r = n − q,    gap = σ_r / max(σ_{r+1}, ν_{r+1})

The rank is *decided* where σ_r exceeds the tolerance tenfold; else a direction lies in the grey zone between
noise and information, and the rank is undecided. What lies below the tolerance is not proved to be zero.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np

from obscli.numeric.gramian import Gramian
from obscli.numeric.program import EPS, Array, Counts, Flags


#: The tolerance in units of the noise, and the factor by which a direction must exceed it.
TOLERANCE: Final = 10.0
CLEAR: Final = 10.0

#: What the decomposition adds, relative to the largest singular value, along one direction.
_DECOMPOSITION: Final = EPS / 8


@dataclass(frozen=True, eq=False)
class Subspaces:
    """The observable row space and the kernel at N instants; everything in scaled units z, x = D z.

    Parameters
    ----------
    gramian : M in scaled units
    values : singular values of M, shape (N, n), the largest first
    left, right : U (N, n, n), and V by rows (N, n, n): M = U diag(values) right
    noise : ν_k, shape (N, n)
    """

    gramian: Gramian
    values: Array
    left: Array
    right: Array
    noise: Array

    @property
    def n(self) -> int:
        """The number of states."""
        return self.gramian.n

    @property
    def instants(self) -> Array:
        """The instants, shape (N,)."""
        return self.gramian.instants

    @cached_property
    def rank(self) -> Counts:
        """r at every instant: how many singular values exceed the tolerance, shape (N,)."""
        clear: Counts = np.logical_and.accumulate(self.values > TOLERANCE * self.noise, axis=1).sum(axis=1)
        return clear

    @cached_property
    def tolerance(self) -> Array:
        """The tolerance on which r rests, 10 ν_{r+1} (10 ν_n where the rank is n), shape (N,)."""
        k = np.minimum(self.rank, self.n - 1)
        tolerance: Array = TOLERANCE * np.take_along_axis(self.noise, k[:, None], axis=1)[:, 0]
        return tolerance

    @cached_property
    def kernel_angle(self) -> Array:
        """The angle to which the kernel is known: tolerance/σ_r, 0 where r is 0, shape (N,)."""
        last = np.take_along_axis(self.values, np.maximum(self.rank - 1, 0)[:, None], axis=1)[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            found: Array = np.where(self.rank > 0, self.tolerance / last, 0.0)
        return found

    @cached_property
    def gap(self) -> Array:
        """σ_r / max(σ_{r+1}, ν): how clearly observable and unobservable part; not a number where r is 0."""
        padded = np.hstack([np.full((len(self.rank), 1), np.nan), self.values, np.zeros((len(self.rank), 1))])
        last = np.take_along_axis(padded, self.rank[:, None], axis=1)[:, 0]
        first = np.take_along_axis(padded, self.rank[:, None] + 1, axis=1)[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            gap: Array = last / np.maximum(first, self.tolerance / TOLERANCE)
        return gap

    @property
    def root_gap(self) -> Array:
        """The gap on the scale of a square root of W, by whatever method, shape (N,)."""
        return self.gap if self.gramian.is_root else np.sqrt(self.gap)

    @cached_property
    def decided(self) -> Flags:
        """Whether no singular value lies in the grey zone, shape (N,)."""
        with np.errstate(invalid="ignore"):
            clear = self.gap >= TOLERANCE * CLEAR
        return np.where(self.rank == 0, self.noise[:, 0] == 0, clear)

    def only(self, i: int) -> Subspaces:
        """Return the subspaces at one instant."""
        part = slice(i, i + 1)
        g = self.gramian
        gramian = replace(
            g,
            instants=g.instants[part],
            starts=g.starts[part],
            matrices=g.matrices[part],
            units=g.units[part],
            error=g.error[part],
            growth=g.growth[part],
        )
        return Subspaces(gramian, self.values[part], self.left[part], self.right[part], self.noise[part])

    def kernel(self, i: int | Counts) -> Array:
        """Return a basis of the kernel in scaled units, orthonormal in the file's, shape (…, n, q).

        In the file's units the basis is D times this one. It is orthonormalised by a factor on the right,
        so that small components keep their relative accuracy; not a number where units are too far apart.

        Parameters
        ----------
        i : an instant, or some of the same rank
        """
        basis = np.swapaxes(self.right[i, self._rank(i) :], -1, -2)
        if not basis.shape[-1]:
            return basis
        triangle: Array = np.linalg.qr(self.gramian.units[i][..., None] * basis, mode="r")  # type: ignore[assignment]
        flat = (np.einsum("...jj->...j", triangle) == 0).any(axis=-1)[..., None, None]
        inverse = np.linalg.inv(np.where(flat, np.eye(triangle.shape[-1]), triangle))
        orthonormal: Array = np.where(flat, np.nan, basis @ inverse)
        return orthonormal

    def pull(self, covectors: Array, i: int | Counts) -> Array:
        """Return |s D M_r⁺| of covectors (…, k, n) in the file's units: how weakly M determines each."""
        r = self._rank(i)
        observable = np.swapaxes(self.right[i, :r], -1, -2)
        inside = (covectors * self.gramian.units[i][..., None, :]) @ observable
        weight: Array = np.linalg.norm(inside / self.values[i, :r][..., None, :], axis=-1)
        return weight

    def noise_along(self, directions: Array, i: int | Counts) -> Array:
        """Return √(vᵀ E v) for the columns of directions (…, n, q) in scaled units, shape (…, q)."""
        squared = (directions * (self.gramian.error[i] @ directions)).sum(axis=-2)
        noise: Array = np.sqrt(np.maximum(squared, 0.0))
        return noise

    def _rank(self, i: int | Counts) -> int:
        """The rank at an instant, or at some of the same rank."""
        return int(np.max(self.rank[i]))


def subspaces(gramian: Gramian) -> Subspaces:
    """Decompose the Gramian at every instant; the decomposition's own rounding joins the error.

    Singular values are found to some units of the largest, columns of zeros included.
    """
    left, values, right = np.linalg.svd(gramian.matrices)
    own = (_DECOMPOSITION * values[:, 0]) ** 2
    error = gramian.error + own[:, None, None] * np.eye(gramian.n)
    along = np.einsum("ikj,ijl,ikl->ik", right, error, right, optimize=True)
    noise = np.sqrt(np.maximum(along[:, ::-1].cumsum(axis=1)[:, ::-1], 0.0))
    return Subspaces(replace(gramian, error=error), values, left, right, noise)
