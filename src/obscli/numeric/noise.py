"""``noise`` of a system in numbers: whitening of the outputs, driving noise, information in the prior.

    E v vᵀ = R δ,   E w wᵀ = Q δ,   E x₀ x₀ᵀ = P₀

A covariance R per sample is taken as a density: what a filter that takes the samples as they come makes of
them, as long as little changes from one sample to the next. With D the times between samples of the outputs
(``every``, else ``step``; 1 where R is a density already)

    D^½ R D^½,

where outputs that are correlated are sampled alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from obscli.model.expression import Expression, is_zero, symbols
from obscli.model.system import Matrix, Noise, Output, System
from obscli.numeric.errors import NotComputableError
from obscli.numeric.numeric_system import NumericSystem, constants_of
from obscli.numeric.program import Array, Counts, Program, constant_value


#: Times between samples that differ by less are one.
_ALIKE: Final = 1e-9


@dataclass(frozen=True, eq=False)
class NoiseModel:
    """The noise of one system.

    Parameters
    ----------
    whitening : L⁻¹ with L Lᵀ = R as a density, shape (m, m): rows of L⁻¹ H count in units of the noise
    drive : Q^(1/2) in the order of G's columns, or of the states, shape (d, d); None: nothing drives
    P0 : initial covariance, shape (n, n); zeros for states without a prior
    """

    system: NumericSystem
    whitening: Array
    drive: Array | None
    P0: Array

    def prior(self, states: Counts | None = None) -> Array:
        """Return rows U with Uᵀ U = P₀⁻¹ on those of some states that have a prior, shape (k, n)."""
        among = np.arange(len(self.P0)) if states is None else states
        given = among[np.diag(self.P0)[among] > 0]
        rows = np.zeros((len(given), len(self.P0)))
        if len(given):
            rows[:, given] = np.linalg.inv(_root(self.P0[np.ix_(given, given)], "P0"))
        return rows

    def driving(self, t: Array) -> Array:
        """Return G(t) Q^(1/2) at instants, shape (k, n, d)."""
        assert self.drive is not None
        G = self.system.system.G
        noise = self.system.system.noise
        if noise is None or noise.driven == "states" or G is None:
            return np.broadcast_to(self.drive, (len(t), *self.drive.shape))
        found = Program(list(G.entries.values())).run(self.system.values(t, {}))
        matrix = np.zeros((len(t), G.rows, G.columns))
        for (i, j), value in zip(G.entries, found, strict=True):
            matrix[:, i, j] = value
        driven: Array = matrix @ self.drive
        return driven


def noise_model(numeric: NumericSystem, still: Sequence[str] = ()) -> NoiseModel:
    """Return the noise of a system in numbers.

    Parameters
    ----------
    still : states that are taken as constant, whatever Q says of them

    Raises
    ------
    NotComputableError
        where there is no R for some output, or a matrix is not positive definite; the text says what to give
    """
    system = numeric.system
    noise = system.noise
    if noise is None:
        raise NotComputableError("the file has no `noise`: give R, and P0 or P0_std where there is a prior")
    constants = constants_of(system)
    R = _matrix(noise.R, "R", constants)
    if R is None:
        raise NotComputableError("`noise` has no R: the density of the noise of the outputs")
    missing = [one.name for k, one in enumerate(system.outputs) if R[k, k] == 0]
    if missing:
        raise NotComputableError(f"`noise` gives no R, or zero, for {', '.join(missing)}")
    R = _density(system, R)
    whitening: Array = np.asarray(np.linalg.inv(_root(R, "R")), dtype=float)
    found = NoiseModel(
        numeric, whitening, _drive(system, noise, constants, still), _prior(system, noise, constants)
    )
    found.prior()  # positive definite, or refused here
    return found


def continuous_noise(numeric: NumericSystem, still: Sequence[str] = ()) -> NoiseModel:
    """Return the noise of a system for those who take the outputs as measured all the time.

    Raises
    ------
    NotComputableError
        as ``noise_model``, and where outputs have outages
    """
    names = ", ".join(numeric.system.interrupted)
    if names:
        hint = "obscli simulate takes samples as they come; else delete the key"
        raise NotComputableError(f"outages of {names} (`during`) are not taken into account here: {hint}")
    if numeric.system.discrete and any(step != 1 for step in steps_of(numeric.system)):
        raise NotComputableError(
            "an output that is not sampled at every step (`every`) is not taken into account here: obscli "
            "simulate takes samples as they come"
        )
    return noise_model(numeric, still)


def steps_of(system: System) -> tuple[float | None, ...]:
    """Return the time between samples of every output; None where R is a density.

    Raises
    ------
    NotComputableError
        where it is not a positive number at the file's values
    """
    constants = constants_of(system)
    step = system.noise.step if system.noise else None
    general = None if step is None else _positive(step, "noise: step", constants)
    if system.discrete:
        return tuple(_whole_step(one, constants) for one in system.outputs)
    return tuple(
        general if one.every is None else _positive(one.every, f"outputs: {one.name}: every", constants)
        for one in system.outputs
    )


def _whole_step(output: Output, constants: dict[str, float]) -> float:
    """Return how many steps of a discrete-time system there are from one sample of an output to the next."""
    if output.every is None:
        return 1.0
    name = f"outputs: {output.name}: every"
    value = _positive(output.every, name, constants)
    if value != round(value):
        raise NotComputableError(
            f"`{name}` is {value:.6g}: a discrete-time model is sampled every so many whole steps"
        )
    return value


def _density(system: System, R: Array) -> Array:
    """Return D^½ R D^½."""
    steps = steps_of(system)
    for i, j in zip(*np.nonzero(np.triu(R, 1)), strict=True):
        if not _is_alike(steps[i], steps[j]):
            raise NotComputableError(
                f"`noise: R` correlates {system.outputs[i].name} and {system.outputs[j].name}, which are not "
                "sampled alike: give both the same `every`, or no correlation"
            )
    D = np.array([1.0 if one is None or system.discrete else one for one in steps])
    return R * np.sqrt(np.outer(D, D))


def _is_alike(one: float | None, other: float | None) -> bool:
    """Whether two outputs are sampled equally often, or both all the time."""
    if one is None or other is None:
        return one is other
    return abs(one - other) <= _ALIKE * one


def _drive(system: System, noise: Noise, constants: dict[str, float], still: Sequence[str]) -> Array | None:
    Q = _matrix(noise.Q, "Q", constants)
    if Q is None:
        return None
    if noise.driven == "states":
        index = [j for j, name in enumerate(system.state_names) if name in set(still)]
        Q[index], Q[:, index] = 0.0, 0.0
    if not Q.any():
        return None
    values, vectors = np.linalg.eigh(Q)
    if values.min() < -1e-12 * values.max():
        raise NotComputableError("`noise: Q` is not positive semidefinite")
    root: Array = vectors * np.sqrt(np.maximum(values, 0.0))
    return root


def _prior(system: System, noise: Noise, constants: dict[str, float]) -> Array:
    P0 = _matrix(noise.P0, "P0", constants)
    if P0 is None or noise.P0 is None:
        return np.zeros((system.n, system.n))
    given = [i for i, j in noise.P0.entries if i == j]
    zero = [system.state_names[i] for i in given if P0[i, i] == 0]
    if zero:
        hint = "leave such a state out (--without), or give a small value"
        raise NotComputableError(f"`noise: P0` of {', '.join(zero)} is zero: {hint}")
    return P0


def _matrix(matrix: Matrix | None, name: str, constants: dict[str, float]) -> Array | None:
    if matrix is None:
        return None
    found = np.zeros((matrix.rows, matrix.columns))
    for (i, j), entry in matrix.entries.items():
        if not is_zero(entry):
            found[i, j] = _number(entry, f"noise: {name}", constants)
    if not np.allclose(found, found.T, rtol=1e-9, atol=0):
        raise NotComputableError(f"`noise: {name}` is not symmetric")
    return found


def _number(entry: Expression, name: str, constants: dict[str, float]) -> float:
    unknown = symbols(entry) - constants.keys()
    if unknown:
        words = f"`{name}` depends on {', '.join(sorted(unknown))}"
        raise NotComputableError(f"{words}: only constants with values are taken")
    value = constant_value(entry, constants)
    if not np.isfinite(value):
        raise NotComputableError(f"`{name}` is not finite")
    return value


def _positive(entry: Expression, name: str, constants: dict[str, float]) -> float:
    value = _number(entry, name, constants)
    if value <= 0:
        raise NotComputableError(f"`{name}` must be positive")
    return value


def _root(matrix: Array, name: str) -> Array:
    try:
        root: Array = np.asarray(np.linalg.cholesky(matrix), dtype=float)
    except np.linalg.LinAlgError:
        raise NotComputableError(f"`noise: {name}` is not positive definite") from None
    return root
