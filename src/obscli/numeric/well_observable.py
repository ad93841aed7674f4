"""How well states are observable at the samples of a filter: σ̃ of the window that starts there.

σ̃ is the equivalent singular value (``window_measures``) of n samples with A and H as they are at the first,
in units of P0 and of the noise: what ``measures --window`` shows. Of a filter's model it is known beforehand.

References
----------
Dong Jinlong, Mo Bo: only states that are well observable are to be fed back.
"""

from __future__ import annotations

import numpy as np

from obscli.numeric.local_windows import (
    Sampling,
    WindowSettings,
    forms_at,
    portion_of,
    stack_at,
    values_of,
)
from obscli.numeric.program import Array
from obscli.numeric.sampled_system import SampledSystem
from obscli.numeric.window_scaling import window_scaling


def equivalent_at_samples(sampled: SampledSystem) -> Array:
    """Return σ̃ of every state in the window that starts at each sample, shape (samples, n).

    Raises
    ------
    NotComputableError
        where a coefficient does not exist at some sample
    """
    numeric, t = sampled.numeric, sampled.schedule.t
    n = numeric.n
    h = float(np.diff(t).min()) if len(t) > 1 else sampled.schedule.stop - sampled.schedule.start
    settings = WindowSettings(n * h, h)
    window = Sampling(float(t[0]), h, len(t), h, n)
    scaling = window_scaling(numeric, "prior", h)
    found = np.empty((len(t), n))
    portion = portion_of(numeric, window)
    for first in range(0, len(t), portion):
        part = t[first : first + portion]
        stack = stack_at(numeric, window, settings, part)
        values = values_of(stack, forms_at(numeric, part), part, settings, scaling)
        found[first : first + portion] = values.equivalent[:, :n]
    return found
