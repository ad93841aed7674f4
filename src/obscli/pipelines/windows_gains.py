"""Which part of an interval a state or quantity gains from: where its windows do at least half of the best.

A window takes 1 − p off the deviation that the prior gives; without a prior it is judged by σ̃.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from obscli.numeric.program import Array, Flags
from obscli.numeric.window_measures import WindowValues
from obscli.pipelines.windows_result import Gain


#: A window that takes less than this off the prior's deviation gains nothing to speak of.
LEAST: Final = 0.01

_SHARE: Final = 0.5


def gains_of(names: Sequence[str], values: WindowValues) -> tuple[Gain, ...]:
    """Return what every linear form gains, and where."""
    informed = bool(np.isfinite(values.posterior).all())
    key = "posterior-ratio" if informed else "equivalent-singular-value"
    shown = values.posterior if informed else values.equivalent
    score = 1 - shown if informed else shown
    least = LEAST if informed else 0.0
    return tuple(_gain(name, key, values.t, shown[:, k], score[:, k], least) for k, name in enumerate(names))


def _gain(name: str, key: str, t: Array, shown: Array, score: Array, least: float) -> Gain:
    best = int(score.argmax())
    good = score >= _SHARE * score[best] if score[best] > least else np.zeros(len(t), dtype=bool)
    return Gain(name, key, float(shown[best]), float(t[best]), ranges_of(t, good))


def ranges_of(t: Array, good: Flags) -> tuple[tuple[float, float], ...]:
    """Return from where to where something holds, first and last instants."""
    padded = np.concatenate([[False], good, [False]]).astype(int)
    turns = np.diff(padded)
    first, last = np.flatnonzero(turns > 0), np.flatnonzero(turns < 0) - 1
    return tuple((float(t[i]), float(t[j])) for i, j in zip(first, last, strict=True))
