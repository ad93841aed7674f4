"""Ranks of many unions of rows of one matrix, at a random point modulo a prime.

A set of rows S is carried as its kernel N (S N = 0, columns), so that what further rows G add to its rank is

    rank (S; G) − rank S = rank G N

The rank found is the generic one but for a chance below 1e-15 a set; it is never above it. What is chosen by
it is proved afterwards.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from flint import nmod_mat

from obscli.exact.exact_system import read_system
from obscli.exact.series import PRIME, SeriesPoint
from obscli.model.system import System


_SEED = 20260411


class RowSets:
    """The rows of the outputs of x' = 0, y = H x, gathered in groups.

    Parameters
    ----------
    system : the static system
    sizes : how many outputs belong to each group, in order
    """

    def __init__(self, system: System, sizes: Sequence[int]) -> None:
        exact = read_system(system)
        point = SeriesPoint(exact.field, 1, _SEED)
        self.columns = n = system.n
        values = [[0] * n for _ in exact.H]
        for dense, row in zip(values, exact.H, strict=True):
            for j, element in row.items():
                dense[j] = int(point.value(element)[0])
        starts = [sum(sizes[:k]) for k in range(len(sizes) + 1)]
        self._groups = [_matrix(values[a:b], n) for a, b in pairwise(starts)]
        self.ranks = tuple(int(group.rank()) for group in self._groups)
        self.nothing = _matrix([[int(i == j) for j in range(n)] for i in range(n)], n)

    def __len__(self) -> int:
        """Return the number of groups."""
        return len(self._groups)

    def gain(self, kernel: nmod_mat, group: int) -> int:
        """Return what a group adds to the rank of a set, given the set's kernel."""
        return int((self._groups[group] * kernel).rank())

    def joined(self, kernel: nmod_mat, group: int) -> nmod_mat:
        """Return the kernel of a set and a group together; columns beyond its basis are zero."""
        basis, _ = (self._groups[group] * kernel).nullspace()
        return kernel * basis

    def rank(self, groups: Sequence[int]) -> int:
        """Return the rank of some groups together."""
        kernel, rank = self.nothing, 0
        for group in groups:
            rank += self.gain(kernel, group)
            kernel = self.joined(kernel, group)
        return rank


def _matrix(rows: Sequence[Sequence[int]], columns: int) -> nmod_mat:
    """Return a matrix with at least one row, of zeros where there is none."""
    rows = rows or [[0] * columns]
    return nmod_mat(len(rows), columns, [value for row in rows for value in row], PRIME)
