"""What a simulation does with the errors of a filter, step after step, and an interrupt between them.

Importing this costs the floating-point libraries.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import TypeAlias

from obscli.model.system import System
from obscli.numeric.mean_response import mean_response
from obscli.numeric.monte_carlo import monte_carlo
from obscli.numeric.program import Array
from obscli.numeric.recorded_errors import RecordedErrors
from obscli.pipelines.request import Progress, SimulateRequest
from obscli.pipelines.simulate_result import Initial, Simulation


#: Adds to a simulation what it has found.
Step: TypeAlias = Callable[[Simulation], Simulation]


def carried_out(found: Simulation, steps: Iterable[Step]) -> tuple[Simulation, bool]:
    """Return the simulation after its steps, and whether an interrupt kept it from some of them."""
    try:
        for step in steps:
            if not is_complete(found):
                break
            found = step(found)
    except KeyboardInterrupt:
        return found, True
    return found, not is_complete(found)


def is_complete(found: Simulation) -> bool:
    """Whether all that was begun has come to the end of the interval."""
    mismatch, runs, initial = found.mismatch, found.monte_carlo, found.initial
    return (
        found.history.complete
        and (mismatch is None or mismatch.history.complete)
        and (runs is None or runs.complete)
        and (initial is None or initial.response.complete)
    )


class ErrorSteps:
    """The mean response to an initial error, and runs with random errors, where they are asked for.

    Parameters
    ----------
    system : the truth at the start
    request : what is asked for
    error : the initial error, shape (n,), not a number where none is given; None: nowhere
    errors : makes the errors of the filter, to be recorded
    progress : told what is being done
    """

    def __init__(
        self,
        system: System,
        request: SimulateRequest,
        error: Array | None,
        errors: Callable[[], RecordedErrors],
        progress: Progress,
    ) -> None:
        self._system = system
        self._request = request
        self._error = error
        self._errors = errors
        self._progress = progress

    def steps(self) -> Iterable[Step]:
        """Yield what is asked for."""
        if self._error is not None:
            yield self._responded
        if self._request.runs:
            yield self._spread

    def _responded(self, found: Simulation) -> Simulation:
        assert self._error is not None
        self._progress("the mean response")
        response = mean_response(self._errors(), self._error, self._progress)
        if not len(response.t):
            raise KeyboardInterrupt
        given = dict(zip(self._system.state_names, self._error.tolist(), strict=True))
        inserted = {name: given[name] for name, _ in self._request.initial}
        return replace(found, initial=Initial(inserted, response))

    def _spread(self, found: Simulation) -> Simulation:
        request = self._request
        runs = monte_carlo(self._errors(), request.runs, request.seed, self._progress, self._error)
        if not len(runs.t):
            raise KeyboardInterrupt
        return replace(found, monte_carlo=runs)
