"""What the numerical pipeline finds about one system: frozen values, no arrays."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias

from obscli.model.expression import Expression
from obscli.model.system import System


@dataclass(frozen=True, slots=True)
class NotComputed:
    """The numerical side could not be run, and why; the text says what to do."""

    reason: str


@dataclass(frozen=True, slots=True, eq=False)
class NumericPoint:
    """The Gramian at one instant.

    Parameters
    ----------
    t, start : the instant, and where its window starts
    stop : where its window stops, for a discrete-time system, where it begins at the instant
    rank, decided : the number of singular values above the tolerance, and whether none is in the grey zone
    gap : σ_r / max(σ_{r+1}, noise), None where the rank is 0
    tolerance : below which a singular value is noise, in the same units
    singular_values : of the square root of the Gramian, states in scaled units, the largest first
    basis : orthonormal rows of the observable row space in the file's units; None where it was not asked for
    """

    t: float
    start: float
    rank: int
    decided: bool
    gap: float | None
    tolerance: float
    singular_values: tuple[float, ...]
    basis: tuple[tuple[float, ...], ...] | None = None
    stop: float | None = None

    @property
    def weakest(self) -> float | None:
        """The smallest singular value that counts, None where the rank is 0."""
        return self.singular_values[self.rank - 1] if self.rank else None


@dataclass(frozen=True, slots=True)
class SampledFile:
    """A file of signals: the functions in it, how many samples, from when to when, how interpolated."""

    file: str
    names: tuple[str, ...]
    count: int
    start: float
    stop: float
    interpolation: str


@dataclass(frozen=True, slots=True, eq=False)
class SignalsFinding:
    """The signals of a system, and how much of the rank is the work of their noise.

    Parameters
    ----------
    noise : standard deviations that the file gives, by function; empty: the signals are taken as exact
    t, shown : the instant of the test, and the rank that the Gramian shows there
    clear : the rank left without what white noise of this size alone would show; None: not tested
    excited : of that, what the calmest signals show as well that noise of this size explains
    calm : the rank of these calmest signals; None: not clear, or not tested
    ratios : how far each direction stands above noise, the largest first
    not_excited : states that the record does not show, or no better than noise alone would
    reason : why it was not tested though there is noise; else empty
    doubts : what looks as if it were in another unit
    """

    files: tuple[SampledFile, ...]
    noise: Mapping[str, float]
    t: float | None = None
    shown: int | None = None
    clear: int | None = None
    excited: int | None = None
    calm: int | None = None
    ratios: tuple[float, ...] = ()
    not_excited: tuple[str, ...] = ()
    reason: str = ""
    doubts: tuple[str, ...] = ()

    @property
    def is_noise(self) -> bool:
        """Whether noise alone accounts for some of the rank."""
        return self.excited is not None and self.shown is not None and self.excited < self.shown


@dataclass(frozen=True, slots=True, eq=False)
class NumericFinding:
    """Rank over time, and what it rests on.

    Parameters
    ----------
    system : the system
    method, rtol, scaling : how the Gramian was found
    start, default : t0, and whether the interval is a default one
    points : the instants
    rank : the largest rank decided at any instant, None where there is none
    sampled : the functions of time for which a sample motion was taken
    window : the shortest window where some are shorter than the whole interval, else None
    states : every state as observable, coupled or unobservable, as the Gramian shows it; may be empty; not
        excited where noise of the signals alone would show it as observable
    groups : states that share combinations
    signals : functions that files give, None where there are none
    """

    system: System
    method: str
    rtol: float
    scaling: str
    start: float
    default: bool
    points: tuple[NumericPoint, ...]
    rank: int | None
    sampled: tuple[str, ...]
    window: float | None
    states: Mapping[str, Literal["observable", "coupled", "unobservable", "not excited"]]
    groups: tuple[tuple[str, ...], ...]
    signals: SignalsFinding | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Guess:
    """A guessed form: ``residual`` of the fit and ``held_back``, largest, relative to the curve.

    ``expression`` is None where the form is not identified; ``reason`` says why. ``in_digits``: an amplitude
    is a number, not a monomial of the parameters.
    """

    expression: Expression | None
    residual: float | None = None
    held_back: float | None = None
    reason: str = ""
    in_digits: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class CoefficientCurve:
    """One coefficient of the reduced echelon basis against time, in the file's units.

    The combination is pivot + Σ coefficient · free; ``fitted`` is the guessed form at the instants.
    """

    pivot: str
    free: str
    instants: tuple[float, ...]
    values: tuple[float, ...]
    errors: tuple[float, ...]
    guess: Guess
    fitted: tuple[float, ...] | None
    standing: Literal["proved", "guess", "refuted", "not identified"] = "guess"


@dataclass(frozen=True, slots=True, eq=False)
class EchelonFinding:
    """The reduced echelon basis as the Gramian shows it: pivots in order, and their coefficients."""

    pivots: tuple[str, ...]
    curves: tuple[CoefficientCurve, ...]


@dataclass(frozen=True, slots=True, eq=False)
class FloquetMode:
    """One Floquet multiplier μ of the hidden motion over a period P.

    Parameters
    ----------
    multiplier : μ, at the most the largest number there is
    exponent : ln μ / P, its imaginary part up to multiples of 2π/P
    error : of μ, relative
    kind : ``neutral`` where |μ| cannot be told from 1
    direction : at the start of the period, by state in the file's units; of a pair of complex μ the first has
        the real part, the second the imaginary part
    """

    multiplier: complex
    exponent: complex
    error: float
    kind: Literal["decaying", "neutral", "growing"]
    direction: Mapping[str, float]


@dataclass(frozen=True, slots=True, eq=False)
class HiddenMotion:
    """What becomes of the unobservable errors from ``start`` to ``stop``.

    Parameters
    ----------
    gains : singular values γ of the transition on the unobservable subspace, the largest first; 0 or
        infinite where there is no number so small or so large
    exponents : ln γ/(stop − start), always finite
    errors : of the gains, relative to each
    directions : at the start, one for each gain, by state in the file's units
    floquet : where the window is a period, its multipliers, the largest first
    """

    start: float
    stop: float
    gains: tuple[float, ...]
    exponents: tuple[float, ...]
    errors: tuple[float, ...]
    directions: tuple[Mapping[str, float], ...]
    floquet: tuple[FloquetMode, ...] = ()

    @property
    def error(self) -> float:
        """The error of the largest gain, relative."""
        return self.errors[0]

    @property
    def multipliers(self) -> tuple[complex, ...]:
        """The Floquet multipliers, the largest first; none where the window is no period."""
        return tuple(one.multiplier for one in self.floquet)

    @property
    def multiplier_error(self) -> float:
        """The largest error of a Floquet multiplier."""
        return max((abs(one.multiplier) * one.error for one in self.floquet), default=0.0)


@dataclass(frozen=True, slots=True, eq=False)
class CrossCheck:
    """Deviations by state from P0 and from 4 P0 at some instants, and how far the two are apart.

    ``apart``: the square root of the largest eigenvalue of P₄ − P₁ where P0 = I, 1 before the first
    output; ``assumed``: states without a prior in the file, taken with the deviation ``scale``, or 1.
    """

    instants: tuple[float, ...]
    deviations: Mapping[str, tuple[float, ...]]
    wider: Mapping[str, tuple[float, ...]]
    apart: tuple[float, ...]
    assumed: tuple[str, ...]


#: What limits a deviation most: driving noise, noise of the outputs, the prior.
Floor: TypeAlias = Literal["Q", "R", "P0"]


@dataclass(frozen=True, slots=True, eq=False)
class Knowledge:
    """How well a linear form in the states is known before and after an interval.

    ``partners``: states whose errors go with its own at the end, with the correlation; ``floor``: what limits
    it, ``without``: the deviation relative to the present one without driving noise, with a hundredth of R,
    of P0; ``assumed``: states without a prior in the file.
    """

    before: float
    after: float
    start: float
    stop: float
    partners: tuple[tuple[str, float], ...]
    floor: Floor
    without: Mapping[Floor, float]
    assumed: tuple[str, ...]
