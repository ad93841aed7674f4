"""The mean errors of a Kalman filter after an initial error: no noise, the gains of the filter.

    e(t₀) = e₀,    e⁺ = (I − K H) e⁻,    e⁻ = Φ e⁺ of the sample before

A filter designed on another model is followed together with the true states, see ``joint_errors``: these
start at e₀, the estimate at zero. The response is linear in e₀.
"""

from __future__ import annotations

import numpy as np

from obscli.model.system import System
from obscli.numeric.feedback import Feedback
from obscli.numeric.joint_errors import Known
from obscli.numeric.linear_forms import Forms
from obscli.numeric.program import Array
from obscli.numeric.progress import Progress, silent
from obscli.numeric.recorded_errors import recorded_errors
from obscli.numeric.schedule import Schedule
from obscli.numeric.simulation_finding import MeanResponse


@np.errstate(over="ignore", invalid="ignore")  # what is not finite is refused
def mean_response(  # noqa: PLR0913 - the system, the error, and what is kept of it
    system: System,
    schedule: Schedule,
    forms: Forms,
    initial: Array,
    recorded: int = 500,
    progress: Progress = silent,
    *,
    filter_: System | None = None,
    filter_schedule: Schedule | None = None,
    feedback: Feedback | None = None,
) -> MeanResponse:
    """Return the mean errors of a filter on ``system``, one of its own model or of ``filter_``.

    Parameters
    ----------
    system, schedule : the truth
    forms : of the filter's states
    initial : e₀, the error of the truth's states before the first sample, shape (n_x,)
    recorded : at how many instants at the most
    progress : told where the filter is; an interrupt keeps what is done
    filter_, filter_schedule : what the filter was designed on, where that is not the truth
    feedback : what is fed back after each sample; None: nothing, output correction

    Raises
    ------
    NotComputableError
        as for ``mismatch_history``
    """
    run = recorded_errors(
        system, schedule, forms, recorded, filter_=filter_, filter_schedule=filter_schedule, feedback=feedback
    )
    pair = run.pair
    errors = _Response(pair.joint(initial[:, None]), pair.states)
    before = run.rows[0] @ pair.common @ initial

    def seen(known: Known, rows: Array) -> Array:
        response: Array = rows @ (known.error_transition @ errors.columns)[:, 0]
        return response

    found, complete = run.look(errors, seen, progress)
    mean = np.array(found).reshape(len(found), len(forms.names))
    return MeanResponse(forms.names, forms.kinds, run.t[: len(found)], before, mean, complete)


class _Response:
    """The column (z, ε) that no noise changes."""

    def __init__(self, column: Array, states: int) -> None:
        self._column = column.copy()
        self._states = states

    @property
    def columns(self) -> Array:
        return self._column

    def add(self, root: Array) -> None:
        """Leave the column: the mean of the noise is zero."""

    def correct(self, rows: Array, noise: Array, gain: Array) -> None:  # noqa: ARG002 - its mean is zero
        self._column[self._states :] -= gain @ (rows @ self._column)

    def move(self, transition: Array) -> None:
        self._column = transition @ self._column
