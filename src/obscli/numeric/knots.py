"""Edges of panels at the samples of signals, and systems side by side."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from obscli.numeric.program import Array


#: A knot nearer to an edge than this share of the panel is at the edge.
_APART: Final = 1e-7


def with_knots(edges: Array, knots: Array) -> tuple[Array, int]:
    """Return the edges with the knots that are not at an edge already, and how many these are."""
    if not len(knots):
        return edges, 0
    after = np.clip(np.searchsorted(edges, knots), 1, len(edges) - 1)
    apart = np.minimum(knots - edges[after - 1], edges[after] - knots)
    fresh = knots[apart > _APART * np.diff(edges)[after - 1]]
    return np.union1d(edges, fresh), len(fresh)


def blocks(parts: Sequence[Array]) -> Array:
    """Return block-diagonal matrices, from stacks of each block."""
    found = np.zeros((len(parts[0]), *np.sum([one.shape[1:] for one in parts], axis=0)))
    row = column = 0
    for one in parts:
        found[:, row : row + one.shape[1], column : column + one.shape[2]] = one
        row, column = row + one.shape[1], column + one.shape[2]
    return found
