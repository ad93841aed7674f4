"""The Floquet–Lyapunov reduction of a periodic system to a stationary one, over one period T.

    A(t + T) = A(t),  M = Φ(t0 + T, t0):    R = log(M)/T,    P(t) = Φ(t, t0) e^{−R (t − t0)}
    x = P(t) z,    z' = R z,    y = H(t) P(t) z,    P(t0) = I,  P(t + T) = P(t)

The eigenvalues of M are the Floquet multipliers μ, those of R the exponents ln μ/T. A negative μ has no real
logarithm: then R = log(M²)/(2T), and P has the period 2T. M is not multiplied out for this. Multipliers of
unlike modulus are separated first, M_b = S_K ⋯ S_1 on each of their subspaces (``periodic_subspaces``), and

    R = Σ_b B_0 R_b L_b,    P_k = Σ_b B_k S_k ⋯ S_1 e^{−R_b (t_k − t0)} L_b,    L_b the rows of [B_0 …]⁻¹

so that what decays by e^-40 is as accurate as what grows. That the result holds is tried on the next period,
with other steps: the residual is how far Φ(t_{k+1} + T, t_k + T) P_k is from P_{k+1} e^{R (t_{k+1} − t_k)}.

References
----------
G. Floquet, Annales de l'École Normale Supérieure 12 (1883); A. M. Lyapunov (1892); V. A. Yakubovich,
V. M. Starzhinskii, Linear Differential Equations with Periodic Coefficients (1975), chapter 2.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
from scipy.linalg import expm, matrix_balance

from obscli.model.system import System
from obscli.numeric.analysis import affordable_steps
from obscli.numeric.errors import NotComputableError, UnfitRequestError
from obscli.numeric.finding import FloquetMode, NotComputed
from obscli.numeric.floquet_finding import Equivalent, Floquet
from obscli.numeric.hidden_motion import named, units_of
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.periodic_reduction import Reduction, periods_of, reduction
from obscli.numeric.periodic_steps import Step, product, steps_between
from obscli.numeric.periodic_subspaces import groups_of
from obscli.numeric.product_eigenvalues import Eigenvalue
from obscli.numeric.product_spectrum import Spectrum, product_spectrum
from obscli.numeric.program import EPS, Array
from obscli.numeric.rates import rates_of
from obscli.numeric.settings import Effort
from obscli.numeric.transition import longest_step


SAMPLES: Final = 32

_STEP_ERROR: Final = 1e-13
_PROBES: Final = 18

#: The steps that the result is tried with are shorter by this.
_OTHER_STEPS: Final = 0.7

#: Entries of A that differ by more than this, relative to the largest of all, and by more than so many times
#: their rounding, do not repeat themselves.
_REPEATS: Final = 1e-8
_ROUNDINGS: Final = 10.0

#: A residual beyond this, or an error of R beyond this part of its size, says that R is not resolved.
_RESIDUAL: Final = 1e-6
_RELATIVE: Final = 1e-3

_TRIES: Final = 4
_SEED: Final = 18_830_101

_LARGEST: Final = float(np.finfo(float).max)


def floquet(system: System, start: float, period: float, samples: int = SAMPLES) -> Floquet:
    """Return the Floquet–Lyapunov reduction of a system whose A(t) repeats itself after a period.

    Parameters
    ----------
    start : t0, where P = I
    period : T > 0, in units of time
    samples : intervals a period at whose ends P is given, at least two

    Raises
    ------
    UnfitRequestError
        where the period is not positive, A(t) does not repeat itself after it, or samples are too few
    NotComputableError
        where the system cannot be integrated
    """
    if not (0 < period < np.inf and np.isfinite(start)):
        raise UnfitRequestError(f"a period is a positive number of units of time, not {period:.6g}")
    if samples < 2:
        raise UnfitRequestError(f"a period is divided into at least 2 intervals, not {samples}")
    numeric = NumericSystem(system, start, start + 2 * period)
    instants = start + period * np.linspace(0.0, 1.0, samples + 1)
    _refuse_aperiodic(numeric, instants, period)
    units = _units(numeric, instants)
    effort = Effort(_STEP_ERROR, affordable_steps(numeric))
    longest = longest_step(rates_of(numeric, np.linspace(start, instants[-1], _PROBES)[1:-1]))
    steps = steps_between(numeric, instants, longest, effort, units)
    whole = product(steps)
    if not np.isfinite(whole.matrix).all():
        raise NotComputableError(
            "solutions grow beyond the largest number within a period: leave out the states that do"
        )
    spectrum = product_spectrum(
        [one.matrix for one in steps], [one.relative_error for one in steps], eigenvalues=True
    )
    try:
        other = steps_between(numeric, instants + period, _OTHER_STEPS * longest, effort, units)
        equivalent: Equivalent | NotComputed = _equivalent(numeric, instants, units, (steps, other), spectrum)
    except np.linalg.LinAlgError:
        equivalent = NotComputed(_unresolved("the subspaces of its multipliers cannot be told apart"))
    except NotComputableError as error:
        equivalent = NotComputed(str(error))
    ratio = units[:, None] / units
    return Floquet(
        start,
        period,
        system.state_names,
        whole.matrix * ratio,
        whole.error * ratio,
        tuple(_modes(system, spectrum, units, period)),
        equivalent,
    )


def _units(numeric: NumericSystem, t: Array) -> Array:
    """Return the sizes of the states: the file's where it gives them, else those that balance |A|, (n,)."""
    given = units_of(numeric.system)
    if (given != 1).any():
        return given
    size = np.zeros((numeric.n, numeric.n))
    size[numeric.moving] = np.abs(numeric.matrices(t)[0]).mean(axis=0)
    return np.asarray(matrix_balance(size, permute=False, separate=True)[1][0], dtype=float)


def _refuse_aperiodic(numeric: NumericSystem, instants: Array, period: float) -> None:
    # instants of their own, so that a period of the samples is not taken for one of the system
    t = instants[:-1] + np.diff(instants) * np.random.default_rng(_SEED).uniform(0, 1, len(instants) - 1)
    now, later = (numeric.coefficients(one) for one in (t, t + period))
    apart = np.abs(later.A - now.A).max(axis=(1, 2), initial=0.0)
    rounding = max(now.A_error.max(initial=0.0), later.A_error.max(initial=0.0))
    if apart.max() > _REPEATS * np.abs(now.A).max(initial=0.0) + _ROUNDINGS * rounding:
        time, at = numeric.system.time, t[apart.argmax()]
        raise UnfitRequestError(
            f"A({time}) does not repeat itself after {period:.6g}: it differs between "
            f"{time} = {at:.6g} and {at + period:.6g}; give a period of A({time})"
        )


def _equivalent(
    numeric: NumericSystem,
    instants: Array,
    units: Array,
    steps_of: tuple[Sequence[Step], Sequence[Step]],
    spectrum: Spectrum,
) -> Equivalent:
    """Return the stationary system; raises where it does not stand.

    Parameters
    ----------
    steps_of : the period, and the next one, on which the result is tried
    """
    steps, other = steps_of
    found, error = _with_error(steps, spectrum)
    R, still = found.R, numeric.constant_states
    R[still] = error[still] = 0
    T, wrong = instants[-1] - instants[0], _norm(error)
    if not wrong <= _RELATIVE * max(_norm(R), 1 / T):
        raise NotComputableError(_unresolved(f"R may be wrong by {wrong:.1e}"))
    ends = [0, *(1 + np.searchsorted([one.stop for one in steps], instants[1:])).tolist()]
    turns = range(found.periods)
    P = found.factor([end + j * len(steps) for j in turns for end in ends[j > 0 :]])
    P[:, still] = np.eye(numeric.n)[still]
    residual = max(found.closing, _tried(P, R, instants, other))
    if not residual <= _RESIDUAL:
        raise NotComputableError(_unresolved(f"the residual is {residual:.1e}"))
    ratio = units[:, None] / units
    t = np.concatenate([instants[j > 0 :] + j * T for j in turns])
    return Equivalent(
        R=R * ratio,
        R_error=error * ratio,
        doubled=found.periods > 1,
        instants=t,
        P=P * ratio,
        outputs=numeric.matrices(t)[1] @ (P * ratio),
        residual=residual,
        condition=float(np.linalg.cond(P).max()),
    )


def _with_error(steps: Sequence[Step], spectrum: Spectrum) -> tuple[Reduction, Array]:
    """Return R and P, and how far R moves when every step is disturbed by its error, (n, n)."""
    groups = groups_of([one.log_modulus for one in spectrum.eigenvalues])
    factors = [one.matrix for one in steps]
    times = np.array([one.stop for one in steps]) - steps[0].start
    turns = periods_of(factors, groups, spectrum.eigenvalue_errors)
    found = reduction(factors, times, groups, turns)
    R = found.R
    error = np.full_like(R, len(R) * len(factors) * EPS * np.abs(R).max())
    for disturbed in _disturbed(steps):
        error = np.maximum(error, np.abs(reduction(disturbed, times, groups, turns).R - R))
    return found, error


def _unresolved(why: str) -> str:
    return f"the logarithm of the monodromy matrix is not resolved: {why}"


def _tried(P: Array, R: Array, instants: Array, other: Sequence[Step]) -> float:
    """Return the largest of |Φ(t_{k+1} + T, t_k + T) P_k − P_{k+1} e^{R h}|, relative to the factors."""
    ends = 1 + np.searchsorted([one.stop for one in other], instants[1:] + (instants[-1] - instants[0]))
    firsts = [0, *ends[:-1]]
    largest = 0.0
    for k in range(len(P) - 1):
        j = k % (len(instants) - 1)
        phi = product(other[firsts[j] : ends[j]]).matrix
        grown = expm(R * (instants[j + 1] - instants[j]))
        size = min(_norm(phi) * _norm(P[k]), _norm(P[k + 1]) * _norm(grown))
        largest = max(largest, _norm(phi @ P[k] - P[k + 1] @ grown) / size)
    return largest


def _norm(matrix: Array) -> float:
    return float(np.linalg.norm(matrix, 2))


def _disturbed(steps: Sequence[Step]) -> Iterator[list[Array]]:
    """Yield the factors, each disturbed as much as all errors together could if they pointed the same way."""
    source, n = np.random.default_rng(_SEED), len(steps[0].matrix)
    for _ in range(_TRIES):
        yield [
            one.matrix
            + np.sqrt(len(steps))
            * (one.error + n * EPS * np.abs(one.matrix))
            * source.normal(size=one.matrix.shape)
            for one in steps
        ]


def _modes(system: System, spectrum: Spectrum, units: Array, period: float) -> Iterator[FloquetMode]:
    for one, error in zip(spectrum.eigenvalues, spectrum.eigenvalue_errors, strict=True):
        vector = units * one.vector
        vector = vector / vector[np.abs(vector).argmax()]
        apart = abs(one.log_modulus) > -np.log1p(-min(error, 0.5))
        yield FloquetMode(
            multiplier=_value(one),
            exponent=complex(one.log_modulus / period, float(np.angle(one.phase)) / period),
            error=float(error),
            kind=("growing" if one.log_modulus > 0 else "decaying") if apart else "neutral",
            direction=named(system, vector.real if one.phase.imag >= 0 else vector.imag),
        )


def _value(one: Eigenvalue) -> complex:
    """Return μ, its modulus no more than the largest number."""
    with np.errstate(over="ignore", under="ignore"):
        return complex(min(np.exp(one.log_modulus), _LARGEST) * one.phase)
