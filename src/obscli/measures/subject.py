"""What measures are taken of: a system at the file's values, an instant, the units of the states, targets.

Which targets are observable is known exactly before any measure is taken: a state that is not is marked so,
whatever number a formula gives.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Final, Literal, TypeAlias

import numpy as np

from obscli.exact.closed_forms import ClosedForms, closed_forms
from obscli.exact.finding import Analysis
from obscli.measures.covariances import Covariances, covariances
from obscli.measures.local import Local, local
from obscli.model.expression import Expression, negate
from obscli.model.system import Covector, System
from obscli.numeric.analysis import affordable_steps
from obscli.numeric.discrete_gramian import discrete_gramian
from obscli.numeric.gramian import Gramian
from obscli.numeric.hidden_motion import named
from obscli.numeric.numeric_system import NumericSystem, derivative_orders
from obscli.numeric.program import Array, Counts, Flags, Program
from obscli.numeric.rates import rates_of
from obscli.numeric.settings import STEP_ERROR, Effort
from obscli.numeric.square_root import square_root_gramian


_PROBES: Final = 18

#: What a target is to the reader.
TargetKind: TypeAlias = Literal["state", "quantity", "combination"]


@dataclass(frozen=True, slots=True, eq=False)
class Target:
    """A linear form in the states, and whether it is observable; None: undecided."""

    name: str
    kind: TargetKind
    coefficients: Covector
    observable: bool | None


@dataclass(frozen=True, eq=False)
class Subject:
    """A system to be measured at an instant.

    Parameters
    ----------
    system : as the file has it
    there : with the parameters replaced by their values
    analysis : the exact one at the file's values
    numeric : the system in floating point over the interval
    start, stop : the interval of the file, or as asked for
    at : the instant
    units : D, the units of the states in which measures are taken, shape (n,)
    targets : states, quantities and combinations, in this order
    options : of measures, by key and name
    step : seconds between samples, where the file does not say
    """

    system: System
    there: System
    analysis: Analysis
    numeric: NumericSystem
    start: float
    stop: float
    at: float
    units: Array
    targets: tuple[Target, ...]
    options: Mapping[str, Mapping[str, float | str]] = field(default_factory=dict)
    step: float | None = None

    @property
    def n(self) -> int:
        """The number of states."""
        return self.system.n

    @property
    def rank(self) -> int:
        """The exact rank at the file's values."""
        return self.analysis.rank

    def number(self, key: str, name: str) -> float:
        """Return an option that is a number."""
        return float(self.options[key][name])

    def word(self, key: str, name: str) -> str:
        """Return an option that is a word."""
        return str(self.options[key][name])

    @cached_property
    def local(self) -> Local:
        """M(t) at the instant.

        Raises
        ------
        NotMeasuredError
            where it does not exist there
        """
        return local(self.numeric, self.there, self.rank, self.at, self.units)

    @cached_property
    def covariances(self) -> Covariances:
        """Deviations at the instant; raises ``NotComputableError`` where the file does not give the noise."""
        return covariances(self, np.array([self.at]))

    @cached_property
    def gramian(self) -> Gramian:
        """The Gramian over the interval; raises ``NotComputableError`` where it cannot be found."""
        numeric = self.numeric
        if self.system.discrete:
            return discrete_gramian(numeric, np.array([self.start]), self.at)
        rates = rates_of(numeric, np.linspace(self.start, self.at, _PROBES)[1:-1])
        effort = Effort(STEP_ERROR["square-root"], affordable_steps(numeric))
        return square_root_gramian(numeric, self.start, np.array([self.at]), rates, effort)

    def forms(self, t: float) -> Array:
        """Return the targets at an instant in the file's units, shape (k, n)."""
        found: Array = self.numeric.covectors([one.coefficients for one in self.targets], np.array([t]))[0][0]
        return found

    def covectors(self, t: float) -> Array:
        """Return the targets at an instant as forms in x_s, x = D x_s, shape (k, n).

        States are taken in their units D, the others in the file's: x_j/d_j, and c x = c D x_s.
        """
        found = self.forms(t) * self.units
        found[self.states] /= self.units[:, None]
        return found

    def directions(self, t: float) -> Array:
        """Return the unobservable directions at an instant, columns, shape (n, n − r)."""
        found: Array = self.numeric.covectors(self.analysis.unobservable, np.array([t]))[0][0]
        return found.T

    @cached_property
    def closed(self) -> ClosedForms | None:
        """Measures in closed form, of all targets; None where there are none."""
        if (self.units != 1).any() or not self.observable.all():
            return None
        return closed_forms(self.system, [one.coefficients for one in self.targets])

    def value(self, expression: Expression) -> float:
        """Return an expression in the names of the system at the file's values, at the instant."""
        values = self.numeric.values(np.array([self.at]), derivative_orders([expression]))
        return float(np.ravel(Program([expression]).run(values)[0])[0])

    def positive(self, expression: Expression) -> Expression:
        """Return an expression with the sign that makes it positive at the file's values."""
        return negate(expression) if self.value(expression) < 0 else expression

    @cached_property
    def observable(self) -> Flags:
        """Which targets are proved to be observable, shape (k,)."""
        return np.array([one.observable is True for one in self.targets], dtype=bool)

    @cached_property
    def is_state(self) -> Flags:
        """Which targets are states, shape (k,)."""
        return np.array([one.kind == "state" for one in self.targets], dtype=bool)

    @property
    def states(self) -> Counts:
        """The targets that are states, in order."""
        return np.flatnonzero(self.is_state)

    def of_states(self, values: Array) -> tuple[float | None, ...]:
        """Return values of the states (n,) as those of all targets, None for the others."""
        found: list[float | None] = [None] * len(self.targets)
        for k, value in zip(self.states, values, strict=True):
            found[k] = float(value)
        return tuple(found)

    def named(self, vector: Array) -> dict[str, float]:
        """Return a direction in units D by state, the largest component 1, without rounding."""
        return named(self.system, vector)
