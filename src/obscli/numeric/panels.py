"""Panels of transition matrices and of rows of Gramians, put together: in order, or side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from obscli.numeric.knots import blocks
from obscli.numeric.program import Array, Flags


@dataclass(frozen=True, slots=True, eq=False)
class Panels:
    """Consecutive panels, ``ends`` (k,).

    ``transition``: the moving states' rows of Φ(a, b), shape (k, p, n);
    ``rows``: √(h w_j) H(τ_j) Φ(τ_j, b), shape (k, s m, n);
    ``transition_error``: squared error of the moving rows of Φ: step, sums, coefficients; shape (k, p, n);
    ``row_error``: squared norm of the columns of the rows' error from sums and coefficients, shape (k, n).
    """

    ends: Array
    transition: Array
    rows: Array
    transition_error: Array
    row_error: Array


#: Panels, the tail of A X, and its size, (k, p, n) both.
Solved: TypeAlias = tuple[Panels, Array, Array]


def beside(parts: Sequence[Solved]) -> Solved:
    """Return independent systems as one, the states of one after those of the other, their outputs added."""
    if len(parts) == 1:
        return parts[0]
    found = [one for one, _, _ in parts]
    panel = Panels(
        ends=found[0].ends,
        transition=blocks([one.transition for one in found]),
        rows=np.concatenate([one.rows for one in found], axis=2),
        transition_error=blocks([one.transition_error for one in found]),
        row_error=np.concatenate([one.row_error for one in found], axis=1),
    )
    return panel, blocks([tail for _, tail, _ in parts]), blocks([size for _, _, size in parts])


def repeated(once: Panels, stop: Array) -> Panels:
    """Return panels followed by the same ones once more, which end at ``stop``."""
    again = replace(once, ends=stop - (once.ends[-1] - once.ends))
    return merged(once, np.ones(len(once.ends), dtype=bool), again)


def merged(coarse: Panels, kept: Flags, fine: Panels) -> Panels:
    """Return the panels that are kept and those that stand for the others, in order."""
    ends = np.concatenate([coarse.ends[kept], fine.ends])
    order = np.argsort(ends)

    def joined(a: Array, b: Array) -> Array:
        return np.concatenate([a[kept], b])[order]

    return Panels(
        ends[order],
        joined(coarse.transition, fine.transition),
        joined(coarse.rows, fine.rows),
        joined(coarse.transition_error, fine.transition_error),
        joined(coarse.row_error, fine.row_error),
    )
