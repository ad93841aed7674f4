"""The smallest sets of runs that determine as much as possible: all of them, or one by a greedy choice.

The rank of a union of row spaces is monotone and submodular. Exhaustively, sets are tried by size, and those
that cannot reach the goal are cut off: what the runs to come add now bounds what they add later. Where that
is too much, the run that adds most is taken again and again; the set found has at most 1 + 1/2 + … + 1/d
times as many runs as the smallest, d the largest rank of one run.

References
----------
L. A. Wolsey, An analysis of the greedy algorithm for the submodular set covering problem (1982), Theorem 1.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Final, TypeAlias

from obscli.exact.row_sets import RowSets


if TYPE_CHECKING:
    from flint import nmod_mat

Progress: TypeAlias = Callable[[str], None]

#: Partial sets looked at (some microseconds each) before the search is left to the greedy choice.
MOST_LOOKS: Final = 2_000_000


@dataclass(frozen=True, slots=True)
class SmallestSets:
    """Sets of runs by index.

    Parameters
    ----------
    rank : what each of them reaches
    sets : the sets, each in order
    exhaustive : whether these are all of the smallest size, and none smaller reaches the rank
    looked_at : how many partial sets were looked at
    guarantee : else: the size found is at most so many times the smallest
    """

    rank: int
    sets: tuple[tuple[int, ...], ...]
    exhaustive: bool
    looked_at: int
    guarantee: float | None = None

    @property
    def size(self) -> int:
        """How many runs each set has."""
        return len(self.sets[0]) if self.sets else 0


class _TooManyError(Exception):
    """More partial sets than are looked at."""


def smallest_sets(
    rows: RowSets,
    forbidden: Sequence[frozenset[int]] = (),
    progress: Progress = lambda _: None,
) -> SmallestSets:
    """Return the smallest sets of runs that reach the largest possible rank.

    Parameters
    ----------
    rows : the row spaces of all candidate runs
    forbidden : sets of which not all members may be chosen
    """
    count = len(rows)
    search = _Search(rows, forbidden)
    whole = rows.rank(range(count))
    try:
        for goal in range(whole, 0, -1):  # less than the whole is all there is where too much is forbidden
            for size in range(1, count + 1):
                progress(f"sets of {size} of {count} candidates")
                found = tuple(search.reaching(goal, size))
                if found:
                    return SmallestSets(goal, found, exhaustive=True, looked_at=search.looked_at)
    except _TooManyError:
        return search.greedy(whole)
    return SmallestSets(0, (), exhaustive=True, looked_at=search.looked_at)


class _Search:
    """Sets of runs, grown one by one; each carried by its kernel and its rank."""

    def __init__(self, rows: RowSets, forbidden: Sequence[frozenset[int]]) -> None:
        self._rows = rows
        self._forbidden = forbidden
        self.looked_at = 0

    def reaching(self, goal: int, size: int) -> Iterator[tuple[int, ...]]:
        """Yield the allowed sets of a size that reach the goal."""
        yield from self._extended((), 0, self._rows.nothing, range(len(self._rows)), goal, size)

    def _extended(
        self,
        chosen: tuple[int, ...],
        rank: int,
        kernel: nmod_mat,
        candidates: Sequence[int],
        goal: int,
        size: int,
    ) -> Iterator[tuple[int, ...]]:
        """Yield the sets that contain those chosen and otherwise candidates."""
        left = size - len(chosen)
        gains = {run: self._gain(kernel, run) for run in candidates if self._is_allowed((*chosen, run))}
        order = sorted(gains, key=lambda run: (-gains[run], run))
        for place, run in enumerate(order):
            # what a run adds later is at most what it adds now; the best of those left bound the rest
            if rank + sum(gains[one] for one in order[place : place + left]) < goal:
                return
            longer = (*chosen, run)
            if left == 1:
                yield tuple(sorted(longer))
            elif place + left <= len(order):
                below = self._rows.joined(kernel, run)
                yield from self._extended(longer, rank + gains[run], below, order[place + 1 :], goal, size)

    def _gain(self, kernel: nmod_mat, run: int) -> int:
        self.looked_at += 1
        if self.looked_at > MOST_LOOKS:
            raise _TooManyError
        return self._rows.gain(kernel, run)

    def _is_allowed(self, chosen: tuple[int, ...]) -> bool:
        return not any(one <= set(chosen) for one in self._forbidden)

    def greedy(self, goal: int) -> SmallestSets:
        """Return one set by taking the run that adds most, again and again."""
        chosen: tuple[int, ...] = ()
        rank, kernel = 0, self._rows.nothing
        while rank < goal:
            options = [k for k in range(len(self._rows)) if self._is_allowed((*chosen, k))]
            gains = {k: self._rows.gain(kernel, k) for k in options if k not in chosen}
            best = max(gains, key=lambda k: (gains[k], -k), default=None)
            if best is None or not gains[best]:
                break
            chosen, rank = (*chosen, best), rank + gains[best]
            kernel = self._rows.joined(kernel, best)
        harmonic = float(sum(Fraction(1, k) for k in range(1, max(self._rows.ranks) + 1)))
        guarantee = None if self._forbidden else harmonic
        kept = tuple(sorted(chosen))
        return SmallestSets(rank, (kept,), exhaustive=False, looked_at=self.looked_at, guarantee=guarantee)
