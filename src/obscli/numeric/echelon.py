"""The reduced echelon basis of the observable covectors at every instant, as the numerical method finds it.

With a kernel basis N normalised to the identity on the free states f, the row of pivot p is

    s_p = x_p + Σ_f c_pf x_f,    c_pf = −N_pf,

and an entry is wrong by at most ‖s_p D M⁺‖ |ΔM D⁻¹ N_f| (as in ``leak``): what does not exceed that is set
to zero. Pivots are sought from the first state to the last, where they are clearest, and kept for all
instants, so that every coefficient is a function of time.

References
----------
V. M. Morozov, F. Yu. Baklanov (2018), numerical method, steps 2 and 3.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final, Literal

import numpy as np

from obscli.numeric.analysis import Numeric
from obscli.numeric.program import EPS, Array, Counts, Flags
from obscli.numeric.subspace import Subspaces


#: A column is independent of those before it if what is left of it exceeds the tilt of the row space by this.
_INDEPENDENT: Final = 100.0

#: An entry differs from zero if it exceeds its error by this.
_CLEAR: Final = 10.0


@dataclass(frozen=True, eq=False)
class EchelonCurves:
    """Coefficients of the reduced echelon basis against time, in the file's units.

    Parameters
    ----------
    names : the states
    pivots, free : their indices, shapes (r,) and (q,)
    instants : the instants used, shape (k,)
    coefficients, errors : c_pf and what it may be wrong by, shape (k, r, q)
    """

    names: tuple[str, ...]
    pivots: Counts
    free: Counts
    instants: Array
    coefficients: Array
    errors: Array

    @cached_property
    def present(self) -> Flags:
        """Which coefficients differ from zero at some instant, shape (r, q)."""
        return np.asarray((np.abs(self.coefficients) > _CLEAR * self.errors).any(axis=0))

    @cached_property
    def cleaned(self) -> Array:
        """The coefficients with those that are only noise set to zero, shape (k, r, q)."""
        return np.where(self.present, self.coefficients, 0.0)

    @property
    def groups(self) -> tuple[tuple[str, ...], ...]:
        """The states that share combinations, a connected component each, in order."""
        label = np.arange(len(self.names))
        for p, row in zip(self.pivots, self.present, strict=True):
            for f in self.free[row]:
                label[label == label[f]] = label[p]
        return tuple(
            tuple(self.names[j] for j in np.flatnonzero(label == one))
            for one in dict.fromkeys(label.tolist())
        )

    @property
    def states(self) -> dict[str, Literal["observable", "coupled", "unobservable"]]:
        """Every state as *observable*, *coupled* or *unobservable*, as far as the Gramian shows."""
        pivots = {self.names[p] for p in self.pivots}
        verdicts: dict[str, Literal["observable", "coupled", "unobservable"]] = {}
        for group in self.groups:
            alone: Literal["observable", "unobservable"] = (
                "observable" if group[0] in pivots else "unobservable"
            )
            verdicts.update(dict.fromkeys(group, alone if len(group) == 1 else "coupled"))
        return {name: verdicts[name] for name in self.names}


def echelon_curves(numeric: Numeric) -> EchelonCurves | None:
    """Return the curves over the instants at which the rank is conclusive; None where there are none."""
    spaces, used = numeric.spaces, np.flatnonzero(numeric.conclusive)
    if not used.size:
        return None
    pivots = _best_pivots(spaces, used)
    if pivots is None:
        return None
    free = np.setdiff1d(np.arange(spaces.n), pivots)
    pairs = [_rows(spaces, int(i), pivots, free) for i in used]
    names = numeric.system.system.state_names
    coefficients, errors = (np.array(part) for part in zip(*pairs, strict=True))
    return EchelonCurves(names, pivots, free, spaces.instants[used], coefficients, errors)


def _tilt(spaces: Subspaces) -> Array:
    """Return how far the row space may be turned: noise over the smallest singular value kept, shape (N,)."""
    last = np.maximum(spaces.rank, 1)[:, None] - 1
    kept = np.take_along_axis(spaces.values, last, axis=1)[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        tilt: Array = np.nan_to_num(spaces.tolerance / 10 / kept, nan=0.0, posinf=np.inf) + EPS
    return tilt


def _best_pivots(spaces: Subspaces, used: Counts) -> Counts | None:
    """Return the pivots found most clearly among some instants, None where they are clear at none."""
    tilt = _tilt(spaces)
    tried = {
        int(used[np.argmin(tilt[used])]),
        *(int(used[k]) for k in np.linspace(0, len(used) - 1, 6, dtype=int)),
    }
    found = [_pivots(spaces, i, float(tilt[i])) for i in sorted(tried)]
    clear, pivots = max(found, key=lambda one: one[0])
    return pivots if clear > _INDEPENDENT and len(pivots) == spaces.rank[used[0]] else None


def _pivots(spaces: Subspaces, i: int, tilt: float) -> tuple[float, Counts]:
    """Return the states whose columns are independent of those before, and how clearly the least of them is.

    What is left of a column is wrong by the tilt of the row space, and by that of every direction taken out:
    a direction fixed by a short remainder turns all later ones.
    """
    columns = spaces.right[i, : spaces.rank[i]].copy()
    error = np.full(spaces.n, tilt)
    found: list[int] = []
    clear = np.inf
    for j in range(spaces.n):
        size = float(np.linalg.norm(columns[:, j]))
        if len(found) == len(columns) or size <= _INDEPENDENT * error[j]:
            continue
        found.append(j)
        clear = min(clear, size / error[j])
        unit = columns[:, j] / size
        along = unit @ columns
        error += np.abs(along) * error[j] / size
        columns -= np.outer(unit, along)
    return clear, np.array(found, dtype=np.intp)


def _rows(spaces: Subspaces, i: int, pivots: Counts, free: Counts) -> tuple[Array, Array]:
    """Return c (r, q) and its error in the file's units at one instant."""
    r, units = spaces.rank[i], spaces.gramian.units[i]
    kernel = spaces.right[i, r:].T
    if not len(free):
        return np.zeros((r, 0)), np.zeros((r, 0))
    kernel = kernel @ np.linalg.inv(kernel[free])
    c = -kernel[pivots]
    rows = np.zeros((r, spaces.n))
    rows[np.arange(r), pivots] = 1
    rows[:, free] = c
    weight = spaces.pull(rows / units, i)
    noise = spaces.noise_along(kernel, i) + EPS * np.linalg.norm(kernel, axis=0)
    scale = units[pivots][:, None] / units[free]
    return c * scale, weight[:, None] * noise * scale
