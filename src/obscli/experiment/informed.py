"""What every run tells of the shared states when its outputs have noise: roots of information that add up.

Within a run the other states start from their own prior and are eliminated; nothing drives the shared ones
and no prior of theirs is in it. So information of runs and prior adds up, in any order:

    P⁻¹ = P₀⁻¹ + Σ S_iᵀ S_i
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from obscli.core.number import bar
from obscli.exact.finding import Undecided
from obscli.exact.without import rows_without
from obscli.experiment.stacked import Progress, RunRows, Stack
from obscli.model.expression import Expression, symbols
from obscli.model.notation import to_text
from obscli.model.system import Covector, Requirement, Run, System
from obscli.numeric.deviation import deviations, unseen
from obscli.numeric.errors import NotComputableError
from obscli.numeric.horizon import Horizon, Wanted, horizon_of
from obscli.numeric.information import information
from obscli.numeric.noise import continuous_noise, steps_of
from obscli.numeric.numeric_system import NumericSystem, constants_of, missing_values
from obscli.numeric.program import Array, Counts, constant_value


#: Rows that degenerate at the start itself are looked at so little later.
_ASIDE: Final = 1e-6

#: At these fractions of a run its information is kept.
FRACTIONS: Final = (*(2.0**-k / 40 for k in (4, 3, 2, 1)), *(k / 40 for k in range(1, 41)))


@dataclass(frozen=True, eq=False)
class RunInformation:
    """One run: instants since its start, shape (N,), and the root of information at each, shape (N, c, c).

    From the exact side, at the file's values: ``rows`` that it determines, shape (r, c), and ``seen``: those
    that it tells anything of when the others start from their prior, shape (s, c).
    """

    run: Run
    elapsed: Array
    roots: Array
    rows: Array
    seen: Array

    @property
    def duration(self) -> float:
        """How long the run lasts."""
        return float(self.elapsed[-1])


@dataclass(frozen=True, eq=False)
class Informed:
    """All runs with the prior of the shared states, and the linear forms whose deviation is asked for.

    Parameters
    ----------
    runs : in order
    prior : rows U with Uᵀ U = P₀⁻¹ on the shared states, shape (k, c)
    states : unit covectors are those of the shared states, in this order
    units : the unit of every state, as the file labels it
    required : name and value of every requirement, with its covector
    covectors : shape (len(required), c)
    driven : shared states that `noise: Q` drives, which is left out
    beside : requirements on what the runs do not share
    other_priors : shared states whose prior is not the same in all runs; that of the first counts
    correlated : whether P₀ correlates what is shared with what starts anew, which is left out
    kernels : of the sets of runs asked for so far
    """

    runs: tuple[RunInformation, ...]
    prior: Array
    states: tuple[str, ...]
    units: Mapping[str, str]
    required: tuple[tuple[str, float], ...]
    covectors: Array
    driven: tuple[str, ...]
    beside: tuple[str, ...]
    other_priors: tuple[str, ...]
    correlated: bool
    kernels: dict[frozenset[int], Array] = field(default_factory=dict)

    def deviation(self, parts: Sequence[tuple[int, int]], *, required: bool = False) -> Array:
        """Return the deviations of all states, or of what is required, given the prior and parts of runs.

        Parameters
        ----------
        parts : a run and the instant of it at which it ends, by their indices
        """
        forms = self.covectors if required else np.eye(len(self.states))
        learned = [self.runs[k].roots[j] for k, j in parts]
        nothing = np.zeros((0, len(self.states)))
        return deviations(
            self.prior, np.concatenate([nothing, *learned]), forms, self.unseen(k for k, _ in parts)
        )

    def unseen(self, runs: Iterable[int]) -> Array:
        """Return the directions that some runs tell nothing of, shape (c, q)."""
        which = frozenset(runs)
        if which not in self.kernels:
            rows = [np.zeros((0, len(self.states))), *(self.runs[k].seen for k in sorted(which))]
            self.kernels[which] = unseen(np.concatenate(rows))
        return self.kernels[which]

    def undetermined(self) -> Array:
        """Return the directions that all runs do not determine, whatever the priors, shape (c, q)."""
        return unseen(np.concatenate([np.zeros((0, len(self.states))), *(one.rows for one in self.runs)]))


def informed(
    there: Stack,
    shared: System,
    requirements: Sequence[Requirement],
    progress: Progress = lambda _: None,
) -> Informed:
    """Return what the runs tell.

    Parameters
    ----------
    there : what the runs determine at the file's values
    shared : the static system over the shared states, with the file's parameters
    requirements : the accuracy asked for
    progress : told what is being done

    Raises
    ------
    NotComputableError
        where the noise is not given, or a run cannot be integrated
    """
    names = shared.state_names
    runs = [one.run for one in there.runs]
    found: dict[int, tuple[Array, Array, Array, Array]] = {}
    for k, run in enumerate(runs, start=1):
        if id(run.system) not in found:
            progress(f"accuracy: {bar(k, len(runs))} {run.name}")
            try:
                found[id(run.system)] = _told(there.runs[k - 1], names)
            except NotComputableError as error:
                raise NotComputableError(
                    f"run {run.name}: {error}" if run.system.noise else str(error)
                ) from None
    model = continuous_noise(_numeric(runs[0].system)[0], names)
    kept = _indices(runs[0].system, names)
    required, covectors, beside = _required(shared, requirements)
    return Informed(
        tuple(RunInformation(one.run, *found[id(one.run.system)]) for one in there.runs),
        model.prior(kept)[:, kept],
        names,
        {one.name: one.unit for one in shared.states},
        required,
        covectors,
        tuple(name for name in names if any(_is_driven(run.system, name) for run in runs)),
        beside,
        tuple(name for name in names if len({_prior_text(run.system, name) for run in runs}) > 1),
        bool(np.delete(model.P0[kept], kept, axis=1).any()),
    )


def _numeric(system: System) -> tuple[NumericSystem, Horizon]:
    """Return a system in floating point over the interval of its run."""
    horizon = horizon_of(system, Wanted())
    return NumericSystem(system, horizon.start, horizon.stop), horizon


def _numbers(rows: Sequence[Covector], names: Sequence[str]) -> Array:
    """Return exact rows without parameters as numbers."""
    found = np.zeros((len(rows), len(names)))
    for i, row in enumerate(rows):
        for name, entry in row.items():
            found[i, names.index(name)] = constant_value(entry, {})
    return found


def _told(one: RunRows, shared: Sequence[str]) -> tuple[Array, Array, Array, Array]:
    """Return instants since a run's start, roots of information there, exact rows without and with priors."""
    run, rows = one.run, _numbers(one.rows, shared)
    numeric, horizon = _numeric(run.system)
    model = continuous_noise(numeric, shared)
    kept = _indices(run.system, shared)
    fresh = np.setdiff1d(np.arange(run.system.n), kept)
    duration = horizon.stop - horizon.start
    elapsed = duration * np.array(FRACTIONS)
    first = min((0.0 if step is None else step for step in steps_of(run.system)), default=0.0)
    elapsed = elapsed[elapsed >= min(first, duration)]  # nothing is known before the first sample
    prior = model.prior(fresh)
    roots = information(model, horizon.start, horizon.start + elapsed, kept, prior)
    seen = _seen(numeric, horizon.start, kept, fresh[~prior[:, fresh].any(axis=0)]) if len(prior) else rows
    return elapsed, roots, rows, seen


def _seen(numeric: NumericSystem, start: float, kept: Counts, without_prior: Counts) -> Array:
    """Return what a run tells of the shared states when the others start from a prior where they have one.

    A direction of theirs is not seen if some start of the states without a prior, and zero for the others,
    gives no output: so the covectors count that are zero on the former, at the start.

    Raises
    ------
    NotComputableError
        where the exact side is undecided, or the start is an instant at which its rows degenerate
    """
    system = numeric.system
    found = rows_without(system, [system.state_names[j] for j in without_prior])
    if isinstance(found, Undecided):
        raise NotComputableError(found.reason)
    for at in (start, start + _ASIDE * max(abs(start), 1.0)):
        rows = numeric.covectors(found, np.array([at]))[0][0]
        size = np.linalg.norm(rows, axis=1)[:, None]
        if np.isfinite(rows).all() and np.linalg.matrix_rank(rows / np.where(size > 0, size, 1.0)) == len(
            found
        ):
            told: Array = rows[:, kept]
            return told
    raise NotComputableError(
        "the start of the run is a special instant: what is seen from there is not clear"
    )


def _indices(system: System, names: Sequence[str]) -> Counts:
    place = {name: j for j, name in enumerate(system.state_names)}
    return np.array([place[name] for name in names], dtype=int)


def _prior_text(system: System, name: str) -> str:
    """Return the row of a state in P₀ as text."""
    if system.noise is None or system.noise.P0 is None:
        return ""
    j = system.state_names.index(name)
    return ", ".join(
        f"{k}: {to_text(entry)}" for (i, k), entry in sorted(system.noise.P0.entries.items()) if i == j
    )


def _is_driven(system: System, name: str) -> bool:
    noise = system.noise
    if noise is None or noise.Q is None or noise.driven != "states":
        return False
    j = system.state_names.index(name)
    return (j, j) in noise.Q.entries and bool(constant_value(noise.Q.entries[j, j], constants_of(system)))


def known_value(value: Expression, system: System) -> float:
    """Return a number in the names of a system.

    Raises
    ------
    NotComputableError
        naming the parameters without a value
    """
    constants = constants_of(system)
    missing = sorted(symbols(value) - constants.keys())
    if missing:
        raise NotComputableError(missing_values(missing))
    found = constant_value(value, constants)
    if found < 0:
        raise NotComputableError(f"{to_text(value)} is negative at the file's values")
    return found


def _required(
    shared: System, requirements: Sequence[Requirement]
) -> tuple[tuple[tuple[str, float], ...], Array, tuple[str, ...]]:
    kept = frozenset(shared.state_names)
    inside = [one for one in requirements if kept.issuperset(one.coefficients)]
    beside = tuple(one.name for one in requirements if not kept.issuperset(one.coefficients))
    forms: list[Covector] = [one.coefficients for one in inside]
    static = NumericSystem(shared, 0.0, 1.0)
    covectors = static.covectors(forms, np.array([1.0]))[0][0] if forms else np.zeros((0, shared.n))
    values = tuple((one.name, known_value(one.value, shared)) for one in inside)
    return values, covectors, beside
