"""The blocks of the observability matrix as they stand, one derivative after the other.

    L_0 = H,   L_{k+1} = L_k' + L_k A

Only for few blocks: unlike the reduced rows of the elimination these grow with every derivative.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from obscli.exact.polynomial import require_small
from obscli.exact.rows import rate_of


if TYPE_CHECKING:
    from collections.abc import Iterator

    from obscli.exact.exact_system import ExactSystem, Row
    from obscli.exact.field import Element

#: The squares of the numbers of terms in all blocks may add up to this; it takes a second or two.
_MOST_WORK: Final = 30_000_000
#: Of a system that varies in time the entries have denominators, and the blocks cost more.
_MOST_WORK_IN_TIME: Final = 3_000_000


def tower(exact: ExactSystem) -> Iterator[tuple[Row, ...]]:
    """Yield L_0, L_1, … without end, one sparse row an output.

    Raises
    ------
    UndecidedError : the blocks grow too large
    JetOverflowError : more derivatives of a function are needed than the field holds
    """
    level, work = exact.H, 0
    most = _MOST_WORK_IN_TIME if exact.varies else _MOST_WORK
    while True:
        yield level
        work += sum(_size(entry) for row in level for entry in row.values())
        require_small(work, most)
        level = tuple(rate_of(exact, row) for row in level)


class Blocks:
    """The blocks L_k of a system by k, each found when it is asked for."""

    def __init__(self, exact: ExactSystem) -> None:
        self._rest = tower(exact)
        self._known: list[tuple[Row, ...]] = []

    def __getitem__(self, k: int) -> tuple[Row, ...]:
        while len(self._known) <= k:
            self._known.append(next(self._rest))
        return self._known[k]


def _size(entry: Element) -> int:
    return (len(entry.num) + len(entry.den)) ** 2
