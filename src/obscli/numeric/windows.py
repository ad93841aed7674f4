"""Shorter windows where the whole one drowns in its own growth, or would take too many steps.

A direction that decays fast makes Φ(τ, t) grow backwards: over a long window (t0, t) what it contributes to
the Gramian outgrows everything else until the rest is below rounding, silently; and steps short enough for it
may be too many. For analytic coefficients the row space of W(t, τ) is the same for every τ < t, and a shorter
window holds less information, not more: where it shows a higher rank, or decides what the whole one does not,
it is right. Windows of a few lengths, falling from 100/(fastest rate), are tried at three instants.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Final, TypeAlias

import numpy as np

from obscli.numeric.errors import TooManyStepsError, UnfitRequestError
from obscli.numeric.gramian import Gramian
from obscli.numeric.program import Array
from obscli.numeric.rates import Rates
from obscli.numeric.subspace import Subspaces


#: Makes the subspaces at one instant t from the window (t − w, t).
Windowed: TypeAlias = Callable[[float, float], Subspaces]

#: Windows along an interval at the most: an hour of work.
MOST_WINDOWS: Final = 20_000_000

_LONGEST: Final = 100.0
_HALVINGS: Final = 7

#: The noise of well-behaved systems stays far below this, in scaled units.
_AMPLIFIED: Final = 1e-11

#: The logarithm of the growth over a window from which on information may drown.
_RISKY: Final = 12.0


def require_fewer(count: float, most: int, what: str, name: str, step: float) -> None:
    """Refuse a step with which there are too many of something.

    Raises
    ------
    UnfitRequestError
        where the count is beyond the most there may be
    """
    if not count <= most:
        raise UnfitRequestError(f"a {name} of {step:g} makes {count:.3g} {what}; {most} at the most")


def windowed(instants: Array, w: float, at: Windowed) -> Subspaces:
    """Return the subspaces at every instant, each from a window of length w."""
    parts = [at(float(t), w) for t in instants]
    return _put_together(parts, instants)


def shortened(spaces: Subspaces, rates: Rates, at: Windowed) -> Mapping[int, Subspaces]:
    """Return, by index, the subspaces at instants where a shorter window shows more.

    Parameters
    ----------
    spaces : as found on the given windows
    rates : of the system
    at : finds the subspaces on another window
    """
    t, length = spaces.instants, np.abs(spaces.instants - spaces.gramian.starts)
    drowned = ~spaces.decided & (spaces.noise[:, 0] > _AMPLIFIED)
    risky = np.maximum(spaces.gramian.growth, rates.backward * length) > _RISKY
    suspects = np.flatnonzero(drowned | risky)
    if not suspects.size or not rates.fastest:
        return {}
    probes = suspects[[0, len(suspects) // 2, -1]]
    longest = min(_LONGEST / rates.fastest, float(length[suspects].max()) / 2)
    best, w = _score([spaces.only(i) for i in probes]), 0.0
    for one in longest / 2.0 ** np.arange(_HALVINGS):
        try:
            score = _score([at(t[i], one) for i in probes])
        except TooManyStepsError:
            continue
        if score > best:
            best, w = score, float(one)
    if not w:
        return {}
    found = {int(i): at(t[i], w) for i in suspects}
    return {i: one for i, one in found.items() if _shows_more(one, spaces.only(i))}


def _shows_more(part: Subspaces, whole: Subspaces) -> bool:
    """Return whether a shorter window decides more, and loses no direction that the whole one shows dimly."""
    return _score([part]) > _score([whole]) and bool(part.rank[0] >= whole.rank[0])


def _score(spaces: Sequence[Subspaces]) -> tuple[int, int]:
    """Return how many instants are decided, and the sum of their ranks: more is better."""
    decided = [int(one.rank[0]) for one in spaces if one.decided[0]]
    return len(decided), sum(decided)


def joined(whole: Subspaces, parts: Mapping[int, Subspaces]) -> Subspaces:
    """Return the subspaces with those at some instants replaced."""
    return _put_together([parts.get(i, whole.only(i)) for i in range(len(whole.instants))], whole.instants)


def _put_together(parts: Sequence[Subspaces], instants: Array) -> Subspaces:
    first = parts[0].gramian
    gramian = Gramian(
        first.method,
        instants,
        np.concatenate([one.gramian.starts for one in parts]),
        np.concatenate([one.gramian.matrices for one in parts]),
        np.concatenate([one.gramian.units for one in parts]),
        np.concatenate([one.gramian.error for one in parts]),
        np.concatenate([one.gramian.growth for one in parts]),
    )
    return Subspaces(
        gramian,
        np.concatenate([one.values for one in parts]),
        np.concatenate([one.left for one in parts]),
        np.concatenate([one.right for one in parts]),
        np.concatenate([one.noise for one in parts]),
    )
