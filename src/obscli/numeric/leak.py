"""χ: how far claimed observable combinations leak into the kernel of the Gramian, and how far rounding may.

    χ_i = max |(s_k/‖s_k‖) · η_j(t_i)|    over the rows s_k and an orthonormal basis η_j of the kernel,

in the file's units. For a right row, s = uᵀ M D⁻¹ with u = (s D M⁺)ᵀ, and with M η = −ΔM η

    |s · η| ≤ ‖u‖ |ΔM η|  (+ rounding of the product),

which is the bound that χ is held against: row by row, so that a strong row is judged strictly although
another is weak.

References
----------
V. M. Morozov, F. Yu. Baklanov (2018), verification of an analytic result, step 4.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from obscli.numeric.program import EPS, Array, Flags
from obscli.numeric.subspace import Subspaces


#: A row shorter than this, relative to its largest length over the instants, has lost its digits.
_DEGENERATE: Final = 1e-6
_PRODUCT: Final = 32.0

#: χ is at most 1; above this the kernel's units are too far apart to be orthonormalised in those of the file.
_IMPOSSIBLE: Final = 1.01
_VACUOUS: Final = 0.1


@dataclass(frozen=True, slots=True, eq=False)
class Leak:
    """χ and its bound by instant and row, shape (N, r); not a number where there is no telling."""

    chi: Array
    bound: Array

    @property
    def judged(self) -> Flags:
        """Where χ tells anything: it is at most 1, so a bound near that does not, shape (N, r)."""
        return np.isfinite(self.chi) & (self.bound <= _VACUOUS)

    @property
    def ratio(self) -> Array:
        """χ over its bound, 0 where it tells nothing, shape (N, r)."""
        return np.where(self.judged, self.chi / np.maximum(self.bound, 1e-300), 0.0)


def leak_of(spaces: Subspaces, rows: Array, errors: Array) -> Leak:
    """Return χ row by row.

    Parameters
    ----------
    rows : the covectors at every instant in the file's units, shape (N, r, n)
    errors : the rounding errors of their entries
    """
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        norms = np.linalg.norm(rows, axis=2)
        lost = ~(norms > _DEGENERATE * np.nanmax(norms, axis=0, initial=0.0))
        unit = rows / norms[:, :, None]
    unit[lost] = np.nan
    chi, bound = np.empty(norms.shape), np.empty(norms.shape)
    with np.errstate(invalid="ignore", divide="ignore"):
        of_rows = np.linalg.norm(errors, axis=2) / norms
    for rank in np.unique(spaces.rank):
        i = np.flatnonzero(spaces.rank == rank)
        kernel = spaces.kernel(i)
        scaled_rows = unit[i] * spaces.gramian.units[i][:, None, :]
        chi[i] = np.abs(scaled_rows @ kernel).max(axis=2, initial=0.0)
        through = spaces.pull(unit[i], i)[:, :, None] * spaces.noise_along(kernel, i)[:, None, :]
        size = np.linalg.norm(kernel, axis=1)[:, None, :]
        of_basis = EPS * np.linalg.norm(scaled_rows, axis=2)[:, :, None] * size
        rounding = _PRODUCT * (EPS + of_rows[i][:, :, None] + of_basis)
        bound[i] = (through + rounding).max(axis=2, initial=0.0)
    chi[lost | (chi > _IMPOSSIBLE)] = np.nan
    return Leak(chi, bound)
