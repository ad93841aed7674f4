"""How fast a system is: rates of its coefficients and of its motion.

All in 1/(unit of time), and none depends on the units of the states:

    ν  fastest rate of change |dθ/dt| of an argument of sin, cos, exp, … in A, H
    λ  largest |eigenvalue| of A(t)
    β  largest −Re(eigenvalue) of A(t): how fast Φ(τ, t) may grow backwards
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from obscli.model.expression import Apply, Expression, TimeDerivative, is_zero, postorder
from obscli.model.system import System
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import EPS, Array, Flags, Program


#: In a chain of more states that feeds back on itself nobody has zero eigenvalues only.
_HIGHEST_POWER: Final = 4


@dataclass(frozen=True, slots=True)
class Rates:
    """ν of the coefficients (with the sample motion), λ of the dynamics, β of decay."""

    coefficients: float
    dynamics: float
    backward: float

    @property
    def fastest(self) -> float:
        """The fastest rate of coefficients and dynamics."""
        return max(self.coefficients, self.dynamics)


def rates_of(system: NumericSystem, t: Array) -> Rates:
    """Return the rates seen at some instants."""
    core = system.matrices(t)[0][:, :, system.moving]  # constant states add only zero eigenvalues
    eigenvalues = np.linalg.eigvals(core)
    eigenvalues[_nilpotent(core)] = 0
    return Rates(
        coefficients=max(_argument_rate(system, t), system.motion.rate if system.motion else 0.0),
        dynamics=float(np.abs(eigenvalues).max(initial=0.0)),
        backward=float((-eigenvalues.real).max(initial=0.0)),
    )


def _nilpotent(core: Array) -> Flags:
    """Return which matrices have a power that vanishes but for rounding; their eigenvalues are eps^(1/k)."""
    power, size = core, np.abs(core)
    found = np.zeros(len(core), dtype=bool)
    for k in range(2, _HIGHEST_POWER + 1):
        with np.errstate(over="ignore", invalid="ignore"):
            power, size = power @ core, size @ np.abs(core)
        largest = size.max(axis=(1, 2), initial=0.0)
        found |= (np.abs(power).max(axis=(1, 2), initial=0.0) <= k * EPS * largest) & np.isfinite(largest)
    return found


def _argument_rate(system: NumericSystem, t: Array) -> float:
    derivatives = argument_derivatives(system.system)
    if not derivatives:
        return 0.0
    found = Program(derivatives).run(system.values(t, {}))
    finite = [one for value in found for one in np.abs(np.atleast_1d(value)) if np.isfinite(one)]
    return float(max(finite, default=0.0))


def argument_derivatives(system: System) -> list[Expression]:
    """Return d/dt of the arguments of elementary functions in A and H that vary with time itself."""
    derive = TimeDerivative(system.time, {}, frozenset())
    roots = [*system.A.entries.values(), *system.H.entries.values()]
    found = [derive(node.argument) for node in postorder(*roots) if isinstance(node, Apply)]
    return [one for one in found if not is_zero(one)]
