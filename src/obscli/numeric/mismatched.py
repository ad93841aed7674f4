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

from obscli.model.system import System
from obscli.numeric.feedback import Feedback
from obscli.numeric.joint_errors import Known
from obscli.numeric.kalman import deviations
from obscli.numeric.linear_forms import Forms
from obscli.numeric.program import Array
from obscli.numeric.progress import Progress, silent
from obscli.numeric.recorded_errors import recorded_errors
from obscli.numeric.schedule import Schedule
from obscli.numeric.simulation_finding import MismatchHistory
from obscli.numeric.square_root_filter import compressed


#: Columns are compressed when they are more than so many per row.
_GATHERED: Final = 4


@np.errstate(over="ignore", invalid="ignore")  # what is not finite is refused
def mismatch_history(  # noqa: PLR0913 - two systems, and what is kept of them
    truth: System,
    filter_: System,
    truth_schedule: Schedule,
    filter_schedule: Schedule,
    forms: Forms,
    recorded: int = 500,
    progress: Progress = silent,
    *,
    feedback: Feedback | None = None,
) -> MismatchHistory:
    """Return the claimed and the true deviations of forms in the filter's states.

    Parameters
    ----------
    forms : of the filter; a state that the truth does not have is zero there
    recorded : at how many instants at the most
    progress : told where the filter is; an interrupt keeps what is done
    feedback : what is fed back after each sample; None: nothing, output correction

    Raises
    ------
    NotComputableError
        where a state has no P0, the filter takes samples that the truth does not have, or a system cannot be
        integrated
    """
    run = recorded_errors(
        truth,
        truth_schedule,
        forms,
        recorded,
        filter_=filter_,
        filter_schedule=filter_schedule,
        feedback=feedback,
    )
    joint = _Root(run.pair.prior, run.pair.states)

    def seen(known: Known, rows: Array) -> tuple[Array, Array]:
        claimed = deviations(rows @ known.filter_transition, known.root)
        return claimed, deviations(rows @ known.error_transition, joint.columns)

    found, complete = run.look(joint, seen, progress)
    claimed, true = np.array(found).reshape(-1, 2, len(forms.names)).swapaxes(0, 1)
    done = run.t[: len(found)]
    return MismatchHistory(
        forms.names,
        forms.kinds,
        done,
        claimed,
        true,
        tuple(name for name in truth.state_names if name not in filter_.state_names),
        filter_schedule.samples_until(done),
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
