"""The shortest durations of runs with which their requirements are met.

Information grows with the duration of every run, so a shorter run never helps. Each run may end at any of the
instants at which its information is known. From several beginnings (all runs at their full length, all cut to
the same fraction), one run after the other is made as short as the others allow, until none can be shorter;
the shortest total is kept. No single run of it can end an instant earlier.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from obscli.experiment.informed import Informed
from obscli.numeric.program import Array


@dataclass(frozen=True, slots=True)
class Durations:
    """The shortest durations found, run by run, their sum, and how finely the instants lie."""

    durations: tuple[float, ...]
    total: float
    steps: tuple[float, ...]


def shortest(informed: Informed, runs: Sequence[int]) -> Durations | None:
    """Return the shortest durations of some runs that meet all requirements; None where full length does not.

    Parameters
    ----------
    runs : indices of the runs chosen
    """
    search = _Search(informed, runs)
    full = tuple(len(one.elapsed) - 1 for one in search.runs)
    if not informed.required or not search.suffices(full):
        return None
    best = min((search.shortened(start, order) for start, order in search.beginnings(full)), key=search.total)
    return Durations(
        tuple(float(one.elapsed[j]) for one, j in zip(search.runs, best, strict=True)),
        search.total(best),
        tuple(one.duration / 40 for one in search.runs),
    )


class _Search:
    """Ends of runs as indices of instants, one a run."""

    def __init__(self, informed: Informed, runs: Sequence[int]) -> None:
        self._informed = informed
        self.indices = list(runs)
        self.runs = [informed.runs[k] for k in runs]
        self._asked: Array = np.array([value for _, value in informed.required])

    def suffices(self, ends: Sequence[int]) -> bool:
        """Whether all requirements are met."""
        parts = list(zip(self.indices, ends, strict=True))
        return bool((self._informed.deviation(parts, required=True) <= self._asked).all())

    def total(self, ends: Sequence[int]) -> float:
        """Return the sum of the durations."""
        return float(sum(one.elapsed[j] for one, j in zip(self.runs, ends, strict=True)))

    def beginnings(self, full: tuple[int, ...]) -> Iterator[tuple[tuple[int, ...], tuple[int, ...]]]:
        """Yield ends that suffice, with the order in which runs are to be shortened."""
        orders = [tuple(np.roll(np.arange(len(full)), k).tolist()) for k in range(len(full))]
        alike = self._alike(full)
        for order in orders:
            yield alike, order
            yield full, order

    def _alike(self, full: tuple[int, ...]) -> tuple[int, ...]:
        """Return all runs cut to the same fraction, the smallest that suffices."""
        low, high = 0, max(full)
        while low < high:
            middle = (low + high) // 2
            if self.suffices(_cut(full, middle)):
                high = middle
            else:
                low = middle + 1
        return _cut(full, high)

    def shortened(self, ends: tuple[int, ...], order: Sequence[int]) -> tuple[int, ...]:
        """Return the ends, each run made as short as the others allow, until none can be shorter."""
        before = None
        while ends != before:
            before = ends
            for k in order:
                ends = self._shorter(ends, k)
        return ends

    def _shorter(self, ends: tuple[int, ...], k: int) -> tuple[int, ...]:
        low, high = 0, ends[k]
        while low < high:
            middle = (low + high) // 2
            if self.suffices((*ends[:k], middle, *ends[k + 1 :])):
                high = middle
            else:
                low = middle + 1
        return (*ends[:k], high, *ends[k + 1 :])


def _cut(full: tuple[int, ...], end: int) -> tuple[int, ...]:
    return tuple(min(one, end) for one in full)
