"""The mean errors of a Kalman filter after an initial error: no noise, the gains of the filter.

    e(t₀) = e₀,    e⁺ = (I − K H) e⁻,    e⁻ = Φ e⁺ of the sample before

A filter designed on another model is followed together with the true states, see ``joint_errors``: these
start at e₀, the estimate at zero. The response is linear in e₀.
"""

from __future__ import annotations

import numpy as np

from obscli.numeric.joint_errors import Known
from obscli.numeric.program import Array
from obscli.numeric.progress import Progress, silent
from obscli.numeric.recorded_errors import RecordedErrors
from obscli.numeric.simulation_finding import MeanResponse


def mean_response(run: RecordedErrors, initial: Array, progress: Progress = silent) -> MeanResponse:
    """Return the mean errors of a filter after an initial error.

    Parameters
    ----------
    run : the filter on the truth
    initial : e₀, the error of the truth's states before the first sample, shape (n_x,); not a number: zero
    progress : told where the filter is; an interrupt keeps what is done

    Raises
    ------
    NotComputableError
        where the covariance is beyond all numbers
    """
    pair, initial = run.pair, np.nan_to_num(initial)
    errors = _Response(pair.joint(initial[:, None]), pair.states)
    before = run.rows[0] @ pair.common @ initial

    def seen(known: Known, rows: Array) -> Array:
        response: Array = rows @ (known.error_transition @ errors.columns)[:, 0]
        return response

    found, complete = run.look(errors, seen, progress)
    forms = run.forms
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
