"""The information of all samples on the state, without a prior: what the Cramér–Rao bound is made of.

On a panel, in coordinates of its start, driving noise x⁺ = x⁻ + M w, w ~ N(0, I), is eliminated, samples are
added:

    ( I    0 )  =  Q' ( *  * )            S ← (   S    )
    ( −SM  S )        ( 0  S⁺)                ( R^(−½) H )

SᵀS = J is the Fisher information on x(t); no unbiased estimate from the samples alone has a covariance below
J⁻¹. Where nothing is seen, S has a kernel, which is known exactly and not decided here. What is known of a
state that decays undriven grows without bound: columns are in units of their own, S x = S̃ z, z = 2^e x.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from obscli.model.system import System
from obscli.numeric.errors import NotComputableError
from obscli.numeric.information import triangle
from obscli.numeric.program import Array, Flags
from obscli.numeric.sampled_system import SampledSystem, timeline_of
from obscli.numeric.schedule import Schedule
from obscli.numeric.wide_rows import WideRows


#: Rows are triangularised when they are more than so many per state.
_GATHERED: Final = 4


@dataclass(frozen=True, slots=True, eq=False)
class Information:
    """The information on a state x in coordinates z = 2^e x, S̃ᵀS̃: ``columns`` S̃ᵀ, and e."""

    columns: WideRows

    @property
    def root(self) -> Array:
        """S̃, shape (r, n)."""
        return self.columns.rows.T

    def forms(self, covectors: Array) -> Array:
        """Return linear forms in x (k, n) as forms in z: zero where so much is known that nothing is left."""
        found: Array = np.ldexp(covectors, -self.columns.exponents)
        return found

    def directions(self, basis: Array) -> Array:
        """Return columns along directions of x (n, q) as such along directions of z."""
        exponents = self.columns.exponents[:, None]
        largest = np.where(basis != 0, exponents, 0).max(axis=0, initial=0)
        found: Array = np.ldexp(basis, exponents - largest)
        return found


def information_roots(system: System, schedule: Schedule, instants: Array) -> list[Information]:
    """Return the information on the state at instants in order, after their samples.

    Parameters
    ----------
    schedule : what is sampled when
    instants : within its interval, shape (k,)

    Raises
    ------
    NotComputableError
        where the noise of an output is not given, or the steps are too many
    """
    sampled = SampledSystem(system, schedule)
    timeline, places = timeline_of([sampled], schedule).including(instants)
    wanted, last = set(places.tolist()), int(places[-1])
    found: dict[int, Information] = {}
    columns = WideRows.of(np.zeros((system.n, 0)))
    for stretch in sampled.stretches(timeline):
        part = slice(stretch.first, stretch.first + len(stretch.rows))
        rows = sampled.whitening(timeline.sample[part]) @ stretch.rows
        for k, taken in enumerate(timeline.sample[part] >= 0):
            if stretch.noise is not None:
                columns = _driven(columns, stretch.noise[k])
            if taken:
                columns = columns.beside([rows[k][np.abs(rows[k]).any(axis=1)].T])
            if columns.rows.shape[1] > _GATHERED * system.n:
                columns = _triangular(columns)
            if part.start + k in wanted:
                found[part.start + k] = Information(
                    _moved(columns, stretch.transition[k], sampled.reach, timeline.t[part.start + k])
                )
        if last < part.stop:
            break
        columns = _moved(columns, stretch.onward, sampled.reach, timeline.t[part.stop - 1])
    return [found[k] for k in places.tolist()]


def _moved(columns: WideRows, transition: Array, reach: Flags, t: float) -> WideRows:
    """Return the information on x(t) = Φ(t, a) x(a), given that on x(a)."""
    try:
        backward = np.where(reach, np.linalg.inv(transition), 0.0)
    except np.linalg.LinAlgError:
        raise NotComputableError(
            f"F is singular at {t:.6g}: the samples then tell some combination of the next state "
            "exactly, and there is no information matrix without a prior"
        ) from None
    return _triangular(columns.moved(backward.T))


def _triangular(columns: WideRows) -> WideRows:
    return WideRows(triangle(columns.rows.T).T, columns.exponents)


def _driven(columns: WideRows, M: Array) -> WideRows:
    """Return the information after driving noise M w, shape (n, d): what shows w many times over cancels it.

    w is taken in units in which M is no larger than 1 in coordinates z.
    """
    n, d = M.shape
    _, magnitude = np.frexp(M)
    units = np.where(M != 0, magnitude + columns.exponents[:, None], 0).max(axis=0, initial=0)
    S, noise = columns.rows.T, np.ldexp(M, columns.exponents[:, None] - units)
    joint = np.zeros((d + len(S), d + n))
    joint[np.arange(d), np.arange(d)] = np.ldexp(1.0, -units)
    joint[d:, :d], joint[d:, d:] = -(S @ noise), S
    return WideRows(triangle(joint)[d:, d:].T, columns.exponents)
