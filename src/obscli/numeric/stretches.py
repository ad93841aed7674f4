"""Windows in order, and the points that each is put together at: the queue of two stacks, all at once.

A window [a, b] is [a, c] and [c, b]. Windows share c until one starts behind it. The stretches before the
points do not overlap; neither do those after them where every point is the stop of a window, so that each
panel is walked once in either direction. Points nearer than that make the stretches after them overlap.

References
----------
K. Tangwongsan, M. Hirzel, S. Schneider (2017), Low-latency sliding-window aggregation in worst-case constant
time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from obscli.numeric.program import Counts


@dataclass(frozen=True, slots=True, eq=False)
class Stretches:
    """Windows [a_i, b_i] as numbers of edges in order, and the G points that they are put together at.

    ``a``, ``b``, ``group``: of windows, shape (N,); ``points`` c, ``first``, ``last``: the first and the last
    window at each, shape (G,).
    """

    a: Counts
    b: Counts
    group: Counts
    points: Counts
    first: Counts
    last: Counts

    @property
    def starts(self) -> Counts:
        """The earliest start of the windows at each point, shape (G,)."""
        return self.a[self.first]

    @property
    def stops(self) -> Counts:
        """The latest stop of the windows at each point, shape (G,)."""
        return self.b[self.last]


def stretches(a: Counts, b: Counts, farthest: Counts) -> Stretches:
    """Return the points: the stop of the first window that starts behind the last point, or one before it.

    Parameters
    ----------
    a, b : edges of the windows, a < b, neither ever decreasing, shape (N,)
    farthest : the farthest point for each, beyond a, shape (N,)
    """
    points: list[int] = []
    group = np.empty_like(b)
    for i, (start, stop) in enumerate(zip(a.tolist(), np.minimum(b, farthest).tolist(), strict=True)):
        if not points or start >= points[-1]:
            points.append(stop)
        group[i] = len(points) - 1
    first = np.searchsorted(group, np.arange(len(points)))
    return Stretches(a, b, group, np.array(points), first, np.append(first[1:], len(a)) - 1)
