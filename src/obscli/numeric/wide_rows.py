"""A matrix whose rows have units of their own, M = 2^e Z: what grows through an interval leaves the doubles.

    2^e' Z' = Φ 2^e Z,    e'_i = 0 while row i stays below 2^K, else about log2 |row i|

Powers of two are exact, and a row of ordinary size is what it would be without units. What is too small to
count beside the largest term of its row underflows to zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from obscli.numeric.program import Array, Counts
from obscli.numeric.square_root_filter import compressed


#: Rows below 2 to this are in units of 1: their squares, and sums of many of them, are doubles.
_ORDINARY: Final = 400


@dataclass(frozen=True, slots=True, eq=False)
class WideRows:
    """M = 2^e Z: ``rows`` Z, shape (n, r), ``exponents`` e, shape (n,)."""

    rows: Array
    exponents: Counts

    @classmethod
    def of(cls, matrix: Array) -> WideRows:
        """Return a matrix as it is."""
        return cls(matrix, np.zeros(len(matrix), dtype=int))

    @property
    def value(self) -> Array:
        """M, infinite where it is beyond all doubles, shape (n, r)."""
        with np.errstate(over="ignore"):
            found: Array = np.ldexp(self.rows, self.exponents[:, None])
        return found

    @property
    def sizes(self) -> Array:
        """log2 of the largest entry of every row of M, −∞ where it is zero, shape (n,)."""
        return _log2(np.abs(self.rows).max(axis=1, initial=0.0)) + self.exponents

    def moved(self, transition: Array) -> WideRows:
        """Return Φ M for a matrix Φ (n, n)."""
        own = self._normalised()
        level = (_log2(transition) + own.sizes).max(axis=1, initial=-np.inf)
        exponents = np.where(level > _ORDINARY, np.round(level), 0.0).astype(int)
        relative = np.ldexp(transition, own.exponents - exponents[:, None])
        return WideRows(relative @ own.rows, exponents)

    def beside(self, parts: Sequence[Array]) -> WideRows:
        """Return M with more columns, (n, …) each."""
        others = [np.ldexp(one, -self.exponents[:, None]) for one in parts]
        return WideRows(np.concatenate([self.rows, *others], axis=1), self.exponents)

    def compressed(self) -> WideRows:
        """Return L, shape (n, n), with L Lᵀ = M Mᵀ."""
        return WideRows(compressed([self.rows]), self.exponents)

    def deviations(self, forms: Array) -> Array:
        """Return |c M| for linear forms c (k, n), infinite where that is beyond all doubles, shape (k,)."""
        units = np.where(forms != 0, self.exponents, 0).max(axis=1, initial=0)
        sizes = np.linalg.norm(np.ldexp(forms, self.exponents - units[:, None]) @ self.rows, axis=1)
        with np.errstate(over="ignore"):
            found: Array = np.ldexp(sizes, units)
        return found

    def _normalised(self) -> WideRows:
        """Return M with rows that have units in those of their size."""
        sizes = self.sizes
        own = np.where((self.exponents != 0) & np.isfinite(sizes), np.round(sizes), 0.0).astype(int)
        return WideRows(np.ldexp(self.rows, (self.exponents - own)[:, None]), own)


def _log2(values: Array) -> Array:
    """Return log2 |values|, −∞ where they are zero."""
    with np.errstate(divide="ignore"):
        found: Array = np.log2(np.abs(values))
    return found
