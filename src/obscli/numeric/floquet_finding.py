"""What the Floquet–Lyapunov reduction finds: multipliers, exponents, the stationary equivalent."""

from __future__ import annotations

from dataclasses import dataclass

from obscli.numeric.finding import FloquetMode, NotComputed
from obscli.numeric.program import Array


@dataclass(frozen=True, slots=True, eq=False)
class Equivalent:
    """The stationary system z' = R z, x = P(t) z, in the file's units.

    Parameters
    ----------
    R : real, shape (n, n), 1/(unit of time); ``R_error`` : what it may be wrong by, shape (n, n)
    doubled : P repeats itself after two periods, not one
    instants : evenly from t0 over the period of P, both ends, shape (k,)
    P : x = P z at the instants, shape (k, n, n)
    outputs : H P at the instants, y = H P z, shape (k, m, n)
    residual : the largest failure of P and R on the next period, and of P to return, relative
    condition : the largest condition of P, states in units of their scale, or balanced where they have none
    """

    R: Array
    R_error: Array
    doubled: bool
    instants: Array
    P: Array
    outputs: Array
    residual: float
    condition: float


@dataclass(frozen=True, slots=True, eq=False)
class Floquet:
    """A periodic system over one period from ``start``.

    Parameters
    ----------
    monodromy : Φ(start + period, start), shape (n, n); ``monodromy_error`` : a bound, shape (n, n)
    modes : multipliers and exponents, the largest first
    equivalent : the stationary system, or why there is none that can be trusted
    """

    start: float
    period: float
    states: tuple[str, ...]
    monodromy: Array
    monodromy_error: Array
    modes: tuple[FloquetMode, ...]
    equivalent: Equivalent | NotComputed

    @property
    def multipliers(self) -> tuple[complex, ...]:
        """The Floquet multipliers, the largest first."""
        return tuple(one.multiplier for one in self.modes)

    @property
    def exponents(self) -> tuple[complex, ...]:
        """The exponents ln μ/period, imaginary parts up to multiples of 2π/period."""
        return tuple(one.exponent for one in self.modes)
