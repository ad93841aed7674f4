"""The determinant of a sparse matrix of balls, by elimination that keeps it sparse.

The pivot is taken in the row with the fewest entries, in its column with the fewest (Markowitz), among
entries whose balls exclude zero. The result is a ball that contains the determinant for any choice.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from flint import arb


def determinant(rows: Sequence[Mapping[int, arb]]) -> arb:
    """Return the ball of the determinant of an n × n matrix given by sparse rows, columns 0 … n - 1.

    The ball is [0 ± ∞] where no pivot can be told from zero.
    """
    active = {k: dict(row) for k, row in enumerate(rows)}
    columns: dict[int, set[int]] = {j: set() for j in range(len(rows))}
    for k, row in active.items():
        for j in row:
            columns[j].add(k)
    product, order = arb(1), []
    while active:
        k = min(active, key=lambda i: len(active[i]))
        row = active.pop(k)
        pivots = [j for j, entry in row.items() if not entry.contains(0)]
        if not pivots:
            return arb(0) if not row else arb("0 +/- inf")
        j = min(pivots, key=lambda c: len(columns[c]))
        product *= row[j]
        order.append((k, j))
        for c in row:
            columns[c].discard(k)
        _eliminate(active, columns, row, j)
    return product if _is_even(order) else -product


def _eliminate(
    active: dict[int, dict[int, arb]], columns: dict[int, set[int]], row: Mapping[int, arb], pivot: int
) -> None:
    """Subtract multiples of a row so that its pivot column is empty in the others."""
    for i in columns.pop(pivot):
        other = active[i]
        factor = other.pop(pivot) / row[pivot]
        for j, entry in row.items():
            if j != pivot:
                other[j] = other[j] - factor * entry if j in other else -factor * entry
                columns[j].add(i)


def _is_even(order: Sequence[tuple[int, int]]) -> bool:
    """Whether the permutation row → column is even, by its cycles."""
    image = dict(order)
    even = True
    while image:
        start, following = image.popitem()
        while following != start:
            even = not even
            following = image.pop(following)
    return even
