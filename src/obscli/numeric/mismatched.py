"""A Kalman filter designed on one model, run on another: what it claims, and what its errors are.

The joint covariance of true states and errors (z, ε) is carried as a square root J, see ``joint_errors``; a
sample appends columns for its noise:

    J ← (J_z          0    )
        (J_ε − K (D J_z + B J_ε)   −K W R^½)

Columns are compressed to a triangle when they have become many.

References
----------
A. Gelb (ed.), Applied Optimal Estimation (1974), 7.2 (sensitivity analysis).
"""

from __future__ import annotations

from typing import Final

import numpy as np

from obscli.numeric.joint_errors import Known
from obscli.numeric.kalman import deviations
from obscli.numeric.program import Array
from obscli.numeric.progress import Progress, silent
from obscli.numeric.recorded_errors import RecordedErrors
from obscli.numeric.simulation_finding import MismatchHistory
from obscli.numeric.square_root_filter import compressed


#: Columns are compressed when they are more than so many per row.
_GATHERED: Final = 4


def mismatch_history(run: RecordedErrors, progress: Progress = silent) -> MismatchHistory:
    """Return the claimed and the true deviations of forms in the filter's states.

    Parameters
    ----------
    run : the filter on the truth; a state that the truth does not have is zero there
    progress : told where the filter is; an interrupt keeps what is done

    Raises
    ------
    NotComputableError
        where the covariance is beyond all numbers
    """
    joint = _Root(run.pair.prior, run.pair.states)

    def seen(known: Known, rows: Array) -> tuple[Array, Array]:
        claimed = deviations(rows @ known.filter_transition, known.root)
        return claimed, deviations(rows @ known.error_transition, joint.columns)

    found, complete = run.look(joint, seen, progress)
    forms = run.forms
    truth, design = (one.numeric.system.state_names for one in (run.pair.truth, run.pair.design))
    claimed, true = np.array(found).reshape(-1, 2, len(forms.names)).swapaxes(0, 1)
    done = run.t[: len(found)]
    return MismatchHistory(
        forms.names,
        forms.kinds,
        done,
        claimed,
        true,
        tuple(name for name in truth if name not in design),
        run.samples_until(done),
        complete,
    )


class _Root:
    """A square root of the covariance of (z, ε)."""

    def __init__(self, root: Array, states: int) -> None:
        self._root = root.copy()
        self._states = states

    @property
    def columns(self) -> Array:
        return self._root

    def add(self, root: Array) -> None:
        self._append(root)

    def correct(self, rows: Array, noise: Array, gain: Array) -> None:
        seen = rows @ self._root
        self._root[self._states :] -= gain @ seen
        self._append(np.concatenate([np.zeros((self._states, noise.shape[1])), -gain @ noise]))

    def move(self, transition: Array) -> None:
        self._root = compressed([transition @ self._root])

    def _append(self, columns: Array) -> None:
        parts = [self._root, columns]
        gathered = self._root.shape[1] + columns.shape[1] > _GATHERED * len(self._root)
        self._root = compressed(parts) if gathered else np.concatenate(parts, axis=1)
