"""What every run tells of the shared states when its outputs have noise: roots of information that add up.

Within a run the other states start from their own prior and are eliminated; nothing drives the shared ones
and no prior of theirs is in it. So information of runs and prior adds up, in any order:

    P⁻¹ = P₀⁻¹ + Σ S_iᵀ S_i
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from obscli.core.number import bar
from obscli.experiment.stacked import Progress
from obscli.model.expression import Expression, symbols
from obscli.model.notation import to_text
from obscli.model.system import Covector, Requirement, Run, System
from obscli.numeric.deviation import deviations
from obscli.numeric.errors import NotComputableError
from obscli.numeric.horizon import Horizon, Wanted, horizon_of
from obscli.numeric.information import information
from obscli.numeric.noise import noise_model
from obscli.numeric.numeric_system import NumericSystem, constants_of, missing_values
from obscli.numeric.program import Array, Counts, constant_value


#: At so many instants of a run its information is kept.
INSTANTS: Final = 40


@dataclass(frozen=True, eq=False)
class RunInformation:
    """One run: instants since its start, shape (N,), and the root of information at each, shape (N, c, c)."""

    run: Run
    elapsed: Array
    roots: Array

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

    def deviation(self, roots: Sequence[Array], *, required: bool = False) -> Array:
        """Return the deviations of all states, or of what is required, given the prior and some roots."""
        forms = self.covectors if required else np.eye(len(self.states))
        learned = np.concatenate(roots) if roots else np.zeros((0, len(self.states)))
        return deviations(self.prior, learned, forms)


def informed(
    runs: Sequence[Run],
    shared: System,
    requirements: Sequence[Requirement],
    progress: Progress = lambda _: None,
) -> Informed:
    """Return what the runs tell.

    Parameters
    ----------
    shared : the static system over the shared states
    requirements : the accuracy asked for
    progress : told what is being done

    Raises
    ------
    NotComputableError
        where the noise is not given, or a run cannot be integrated
    """
    names = shared.state_names
    found: dict[int, RunInformation] = {}
    for k, run in enumerate(runs, start=1):
        if id(run.system) not in found:
            progress(f"accuracy: {bar(k, len(runs))} {run.name}")
            try:
                found[id(run.system)] = _told(run, names)
            except NotComputableError as error:
                raise NotComputableError(
                    f"run {run.name}: {error}" if run.system.noise else str(error)
                ) from None
    model = noise_model(_numeric(runs[0].system)[0], names)
    kept = _indices(runs[0].system, names)
    required, covectors, beside = _required(shared, requirements)
    return Informed(
        tuple(
            RunInformation(run, found[id(run.system)].elapsed, found[id(run.system)].roots) for run in runs
        ),
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


def _told(run: Run, shared: Sequence[str]) -> RunInformation:
    numeric, horizon = _numeric(run.system)
    model = noise_model(numeric, shared)
    kept = _indices(run.system, shared)
    fresh = np.setdiff1d(np.arange(run.system.n), kept)
    duration = horizon.stop - horizon.start
    elapsed = duration * np.arange(1, INSTANTS + 1) / INSTANTS
    roots = information(model, horizon.start, horizon.start + elapsed, kept, model.prior(fresh))
    return RunInformation(run, elapsed, roots)


def _indices(system: System, names: Sequence[str]) -> Counts:
    place = {name: j for j, name in enumerate(system.state_names)}
    return np.array([place[name] for name in names], dtype=int)


def _prior_text(system: System, name: str) -> str:
    return to_text(system.prior[name]) if name in system.prior else ""


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
    return constant_value(value, constants)


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
