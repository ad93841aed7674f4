"""Ranks of many unions of rows of one matrix, at a random point modulo a prime.

The rank found is the generic one but for a chance below 1e-15 a set; it is never above it. What is chosen by
it is proved afterwards.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TypeAlias

from flint import nmod_mat

from obscli.exact.exact_system import read_system
from obscli.exact.series import PRIME, SeriesPoint
from obscli.model.system import System


_SEED = 20260411

#: Rows of values modulo PRIME, a reduced basis of their span.
Span: TypeAlias = "tuple[tuple[int, ...], ...]"


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
        self.columns = system.n
        values = []
        for row in exact.H:
            dense = [0] * system.n
            for j, element in row.items():
                dense[j] = int(point.value(element)[0])
            values.append(tuple(dense))
        starts = [sum(sizes[:k]) for k in range(len(sizes) + 1)]
        self.groups: tuple[Span, ...] = tuple(self.union((), tuple(values[a:b])) for a, b in pairwise(starts))

    def union(self, span: Span, rows: Span) -> Span:
        """Return a reduced basis of two spans together."""
        both = [*span, *rows]
        if not both:
            return ()
        reduced, rank = nmod_mat(len(both), self.columns, [v for row in both for v in row], PRIME).rref()
        return tuple(tuple(int(reduced[i, j]) for j in range(self.columns)) for i in range(rank))

    def rank(self, groups: Sequence[int]) -> int:
        """Return the rank of some groups together."""
        rows = [row for k in groups for row in self.groups[k]]
        if not rows:
            return 0
        flat = [value for row in rows for value in row]
        rank: int = nmod_mat(len(rows), self.columns, flat, PRIME).rank()
        return rank
