"""What the noise of the file makes of the targets: deviations before, by the filter, without measurements.

    σ₀ = |c L₀|,   σ⁺ = |c L⁺|,   σ⁻ = |c L⁻|,    P = L Lᵀ

and the smallest that the samples alone allow.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from scipy.linalg import null_space

from obscli.numeric.deviation import deviations
from obscli.numeric.information_bound import information_roots
from obscli.numeric.kalman import roots_at
from obscli.numeric.noise import noise_model
from obscli.numeric.program import Array
from obscli.numeric.schedule import Schedule, schedule_of


if TYPE_CHECKING:
    from obscli.measures.subject import Subject


#: Directions that weigh less than this, columns of unit length, are not told apart in double precision.
_RESOLVED: Final = 1e-13

#: Deviations from two square roots that belong to equal covariances differ by no more, relatively.
_ROUNDING: Final = 1e-12


@dataclass(frozen=True, slots=True, eq=False)
class Covariances:
    """Deviations of the targets at instants, in the file's units.

    Parameters
    ----------
    prior : σ₀, shape (k,)
    after, open_loop : σ⁺ and σ⁻, infinite where it grows beyond all numbers, shape (instants, k)
    first : L₀, shape (n, n)
    last : L⁺ at the last instant, shape (n, n)
    """

    prior: Array
    after: Array
    open_loop: Array
    first: Array
    last: Array


def covariances(subject: Subject, instants: Array) -> Covariances:
    """Return the deviations of the targets at instants in order.

    Raises
    ------
    NotComputableError
        where the file does not give the noise of every output and a prior of every state
    """
    schedule = _schedule(subject, float(instants[-1]))
    after, open_loop = roots_at(subject.system, schedule, instants)
    first: Array = np.asarray(np.linalg.cholesky(noise_model(subject.numeric).P0), dtype=float)
    forms = [subject.forms(float(t)) for t in (subject.start, *instants)]
    return Covariances(
        prior=_sizes(forms[0], first),
        after=np.array([_sizes(c, root) for c, root in zip(forms[1:], after, strict=True)]),
        open_loop=np.array([opened.deviations(c) for c, opened in zip(forms[1:], open_loop, strict=True)]),
        first=first,
        last=after[-1],
    )


def _sizes(forms: Array, root: Array) -> Array:
    size: Array = np.linalg.norm(forms @ root, axis=1)
    return size


def _schedule(subject: Subject, stop: float) -> Schedule:
    return schedule_of(subject.system, subject.start, max(stop, subject.stop), subject.step)


def sampled_instants(subject: Subject, most: int) -> Array:
    """Return instants up to that of the subject at which something is sampled, no more than so many."""
    t = _schedule(subject, subject.at).t
    t = t[t <= subject.at]
    chosen = np.unique(np.round(np.linspace(0, len(t) - 1, min(most, len(t)))).astype(int))
    found: Array = t[chosen]
    return found


def shares(found: Covariances) -> Array:
    """Return 1 − σ⁺/σ⁻, shape (instants, k); not a number where σ⁻ is zero.

    The filter is never worse than no measurements (P⁺ ≤ P⁻): what is below zero by rounding is zero.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        part: Array = 1 - found.after / found.open_loop
    part = np.where((part < 0) & (part > -_ROUNDING), 0.0, part)
    return np.where(found.open_loop > 0, part, np.nan)


def bounds_at(subject: Subject, instants: Array) -> Array:
    """Return the Cramér–Rao bounds of the targets at instants, infinite where a target is not observable.

    Not a number at instants at which the samples so far do not tell all observable combinations apart.

    Raises
    ------
    NotComputableError
        where the file does not give the noise of every output
    """
    schedule = _schedule(subject, float(instants[-1]))
    nothing = np.zeros((0, subject.n))
    found = []
    for t, known in zip(instants, information_roots(subject.system, schedule, instants), strict=True):
        kernel = known.directions(subject.directions(float(t)))
        if _resolved(known.root, kernel):
            bound = deviations(nothing, known.root, known.forms(subject.forms(float(t))), kernel)
        else:
            bound = np.full(len(subject.targets), np.nan)
        found.append(np.where(subject.observable, bound, np.inf))
    return np.array(found)


def _resolved(root: Array, kernel: Array) -> bool:
    """Whether information sees every direction outside its known kernel, columns taken alike."""
    size = np.linalg.norm(root, axis=0) if len(root) else np.zeros(kernel.shape[0])
    units = np.where(size > 0, size, 1.0)
    outside = null_space((kernel * units[:, None]).T) if kernel.size else np.eye(len(units))
    values = np.linalg.svd(root / units @ outside, compute_uv=False)
    count = outside.shape[1]
    return len(values) >= count and bool((values[:count] > _RESOLVED).all())
