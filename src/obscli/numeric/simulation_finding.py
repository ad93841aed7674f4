"""What a simulation of the Kalman filter finds: histories of deviations, and how consistent they are.

Notation: k instants recorded, r linear forms followed (states, quantities, combinations). An instant stands
for what is known after everything sampled at it has been taken.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from obscli.numeric.program import Array


#: What a linear form is to its reader.
Followed: TypeAlias = Literal["state", "quantity", "combination"]

#: What a deviation is held against: the accuracy asked for, or a fraction of the prior.
Criterion: TypeAlias = Literal["require", "fraction"]


@dataclass(frozen=True, slots=True, eq=False)
class History:
    """Standard deviations of the errors of a Kalman filter along an interval.

    Parameters
    ----------
    names, kinds : of the linear forms, (r,) each
    t : instants recorded, the start among them, shape (k,)
    deviations : σ(t) of the filter, shape (k, r)
    open_loop : σ⁻(t) had nothing been measured, shape (k, r)
    prior : σ before the first sample, shape (r,)
    samples : how many samples of single outputs were taken
    complete : whether the end was reached; False: interrupted, all before is kept
    """

    names: tuple[str, ...]
    kinds: tuple[Followed, ...]
    t: Array
    deviations: Array
    open_loop: Array
    prior: Array
    samples: int
    complete: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class MeanResponse:
    """The mean errors of a filter after an initial error.

    ``before``: of the forms, before the first sample, shape (r,); ``mean``: after the samples at the instants
    ``t``, shape (k, r).
    """

    names: tuple[str, ...]
    kinds: tuple[Followed, ...]
    t: Array
    before: Array
    mean: Array
    complete: bool = True


@dataclass(frozen=True, slots=True)
class TimeToObservability:
    """When a deviation falls below a limit for good, None: not within the interval.

    ``limit``: the deviation asked for, in the units of the file; ``because``: where it comes from.
    """

    name: str
    limit: float
    because: Criterion
    reached: float | None


@dataclass(frozen=True, slots=True, eq=False)
class MismatchHistory:
    """A filter designed on one model, run on another: what it claims, and what its errors are.

    ``names`` (r,): forms in the filter's states; ``claimed``, ``true``: standard deviations, shape (k, r);
    ``ignored``: states of the truth that the filter does not have.
    """

    names: tuple[str, ...]
    kinds: tuple[Followed, ...]
    t: Array
    claimed: Array
    true: Array
    ignored: tuple[str, ...]
    samples: int
    complete: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class Consistency:
    """An average over runs that has a χ² distribution where the filter is consistent.

    Parameters
    ----------
    t : instants, shape (k,)
    average : the average over the runs divided by its degrees of freedom: 1 is expected, shape (k,)
    lower, upper : the band that holds it with the confidence asked for, shape (k,) each
    degrees : of freedom, those of all runs together, shape (k,)
    inside : the fraction of the instants at which it is within the band
    """

    t: Array
    average: Array
    lower: Array
    upper: Array
    degrees: Array
    inside: float


@dataclass(frozen=True, slots=True, eq=False)
class MonteCarlo:
    """Runs with random errors, and whether they spread as the filter says.

    Parameters
    ----------
    runs, seed : how many, and from which seed of the generator
    t : instants recorded, shape (k,)
    mean, rms : of the errors over the runs, shape (k, r)
    claimed : σ of the filter at the same instants, shape (k, r)
    nees : normalised estimation error squared, eᵀ P⁻¹ e; None: P is zero all the time
    nis : normalised innovation squared, νᵀ S⁻¹ ν; None: no output is sampled
    confidence : of the bands, 0.95
    inserted : whether errors at the start were given, and not all drawn from P0
    """

    names: tuple[str, ...]
    kinds: tuple[Followed, ...]
    runs: int
    seed: int
    t: Array
    mean: Array
    rms: Array
    claimed: Array
    nees: Consistency | None
    nis: Consistency | None
    confidence: float
    complete: bool = True
    inserted: bool = False
