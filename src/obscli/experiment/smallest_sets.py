"""The smallest sets of runs that determine as much as possible: all of them, or one by a greedy choice.

The rank of a union of row spaces is monotone and submodular. Exhaustively, sets are tried by size and
those that cannot reach the goal are cut off: the rank of a part and the largest ranks of the runs to come
bound what it can reach. Where that is too much, the run that adds most is taken again and again; the set
found has at most 1 + 1/2 + … + 1/d times as many runs as the smallest, d the largest rank of one run.

References
----------
L. A. Wolsey, An analysis of the greedy algorithm for the submodular set covering problem (1982), Theorem 1.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Final, TypeAlias

from obscli.exact.row_sets import RowSets, Span


Progress: TypeAlias = Callable[[str], None]

#: Partial sets looked at before the search is left to the greedy choice.
MOST_LOOKS: Final = 200_000


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
    count = len(rows.groups)
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
    def __init__(self, rows: RowSets, forbidden: Sequence[frozenset[int]]) -> None:
        self._rows = rows
        self._forbidden = forbidden
        # runs that determine much first: sets that reach the goal and bounds that cut come early
        self._order = sorted(range(len(rows.groups)), key=lambda k: (-len(rows.groups[k]), k))
        self.looked_at = 0

    def reaching(self, goal: int, size: int) -> Iterator[tuple[int, ...]]:
        """Yield the allowed sets of a size that reach the goal."""
        yield from self._extended((), (), 0, goal, size)

    def _extended(
        self, chosen: tuple[int, ...], span: Span, start: int, goal: int, size: int
    ) -> Iterator[tuple[int, ...]]:
        left = size - len(chosen)
        if not left:
            if len(span) == goal:
                yield tuple(sorted(chosen))
            return
        for place in range(start, len(self._order) - left + 1):
            run = self._order[place]
            # the runs are sorted by rank: what the next ones can add is bounded by theirs
            if len(span) + left * len(self._rows.groups[run]) < goal:
                return
            if not self._is_allowed((*chosen, run)):
                continue
            self.looked_at += 1
            if self.looked_at > MOST_LOOKS:
                raise _TooManyError
            yield from self._extended(
                (*chosen, run), self._rows.union(span, self._rows.groups[run]), place + 1, goal, size
            )

    def _is_allowed(self, chosen: tuple[int, ...]) -> bool:
        return not any(one <= set(chosen) for one in self._forbidden)

    def greedy(self, goal: int) -> SmallestSets:
        """Return one set by taking the run that adds most, again and again."""
        chosen: tuple[int, ...] = ()
        span: Span = ()
        while len(span) < goal:
            options = [k for k in self._order if k not in chosen and self._is_allowed((*chosen, k))]
            spans = {k: self._rows.union(span, self._rows.groups[k]) for k in options}
            best = max(options, key=lambda k: (len(spans[k]), -k), default=None)
            if best is None or len(spans[best]) == len(span):
                break
            chosen, span = (*chosen, best), spans[best]
        largest = max(len(group) for group in self._rows.groups)
        harmonic = float(sum(Fraction(1, k) for k in range(1, largest + 1)))
        guarantee = None if self._forbidden else harmonic
        kept = tuple(sorted(chosen))
        return SmallestSets(
            len(span), (kept,), exhaustive=False, looked_at=self.looked_at, guarantee=guarantee
        )
