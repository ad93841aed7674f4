"""Feedback of a filter's estimates: the system is corrected by an estimate, which is then set to zero.

    x ← x − Eᵀ M x̂,    x̂ ← (I − M) x̂,    M = diag(0 or 1)

E: the states of the filter among the true ones. The error e = E x − x̂ is the same before and after; what
follows differs, as what was fed back moves from then on as the truth does, what was not (output correction: M
= 0) as the filter's model says. For equal models both are the same. On a panel, in the coordinates of
``joint_errors``:

    x̂ = Φ_f (E z − ε),    δz = −Φ⁻¹ Eᵀ M x̂,    δε = (E − Φ_f⁻¹ E Φ) δz
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from obscli.numeric.errors import UnfitRequestError
from obscli.numeric.program import Array, Flags


@dataclass(frozen=True, slots=True)
class Feedback:
    """Which estimates are fed back after each sample.

    ``states``: their names, None: all that both models have. Of these, ``above``: only those whose equivalent
    singular value is then above this, see ``well_observable``; ``below``: only those whose deviation, as the
    filter claims it, is then below this fraction of its prior.
    """

    states: tuple[str, ...] | None = None
    below: float | None = None
    above: float | None = None

    def allowed(self, own: Sequence[str], true: Sequence[str]) -> Flags:
        """Return which states of the filter may be fed back, shape (n_f,).

        Raises
        ------
        UnfitRequestError
            where one that is named is not a state of both models
        """
        for name in self.states or ():
            if name not in own or name not in true:
                whose = "filter" if name not in own else "true model, where there is nothing to correct"
                raise UnfitRequestError(f"--feedback {name}: no state of the {whose}")
        wanted = true if self.states is None else self.states
        return np.array([name in wanted and name in true for name in own])


def fed_back(common: Array, true_part: Array, own_part: Array, taken: Flags) -> Array:
    """Return what takes (z, ε) from before a feedback to after it, shape (n_x + n_f, n_x + n_f).

    Parameters
    ----------
    common : E, shape (n_f, n_x)
    true_part, own_part : Φ and Φ_f from the start of the panel
    taken : which states of the filter are fed back, shape (n_f,)
    """
    n_x = len(true_part)
    estimate = np.concatenate([own_part @ common, -own_part], axis=1)
    moved = -np.linalg.solve(true_part, (common.T * taken) @ estimate)
    others = common - np.linalg.solve(own_part, common @ true_part)
    found = np.eye(n_x + len(own_part))
    found[:n_x] += moved
    found[n_x:] += others @ moved
    return found
