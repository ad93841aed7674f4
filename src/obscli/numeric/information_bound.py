"""The information of all samples on the state, without a prior: what the Cramér–Rao bound is made of.

On a panel, in coordinates of its start, driving noise x⁺ = x⁻ + M w, w ~ N(0, I), is eliminated, samples are
added:

    ( I    0 )  =  Q' ( *  * )            S ← (   S    )
    ( −SM  S )        ( 0  S⁺)                ( R^(−½) H )

SᵀS = J is the Fisher information on x(t); no unbiased estimate from the samples alone has a covariance below
J⁻¹. Where nothing is seen, S has a kernel, which is known exactly and not decided here.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from obscli.model.system import System
from obscli.numeric.errors import NotComputableError
from obscli.numeric.information import driven, triangle
from obscli.numeric.program import Array
from obscli.numeric.sampled_system import SampledSystem, timeline_of
from obscli.numeric.schedule import Schedule


#: Rows are triangularised when they are more than so many per state.
_GATHERED: Final = 4


def information_roots(system: System, schedule: Schedule, instants: Array) -> list[Array]:
    """Return S with SᵀS the information on the state at instants in order, after their samples.

    Parameters
    ----------
    schedule : what is sampled when
    instants : within its interval, shape (k,)

    Raises
    ------
    NotComputableError
        where the noise of an output is not given, the steps are too many, or a state decays too far
    """
    sampled = SampledSystem(system, schedule)
    timeline, places = timeline_of([sampled], schedule).including(instants)
    wanted, last = set(places.tolist()), int(places[-1])
    found: dict[int, Array] = {}
    root = np.zeros((0, system.n))
    for stretch in sampled.stretches(timeline):
        part = slice(stretch.first, stretch.first + len(stretch.rows))
        rows = sampled.whitening(timeline.sample[part]) @ stretch.rows
        for k, taken in enumerate(timeline.sample[part] >= 0):
            if stretch.noise is not None:
                root = driven(root, stretch.noise[k])
            if taken:
                root = np.concatenate([root, rows[k][np.abs(rows[k]).any(axis=1)]])
            if len(root) > _GATHERED * system.n:
                root = triangle(root)
            if part.start + k in wanted:
                found[part.start + k] = _moved(root, stretch.transition[k], timeline.t[part.start + k])
        if last < part.stop:
            break
        root = _moved(root, stretch.onward, timeline.t[part.stop - 1])
    return [found[k] for k in places.tolist()]


def _moved(root: Array, transition: Array, t: float) -> Array:
    """Return the information on x(t) = Φ(t, a) x(a), given that on x(a)."""
    try:
        moved = triangle(np.asarray(np.linalg.solve(transition.T, root.T).T, dtype=float))
    except np.linalg.LinAlgError:
        raise NotComputableError(
            f"F is singular at {t:.6g}: the samples then tell some combination of the next state "
            "exactly, and there is no information matrix without a prior"
        ) from None
    if not np.isfinite(moved).all():
        raise NotComputableError(
            f"the information overflows at {t:.6g}: a state decays too far; give a shorter interval (--to)"
        )
    return moved
