"""The Riccati equation from two priors: where what is hidden dies out, both end in the same covariance.

    P(t) from P0 and from 4 P0:    detectable  ⟹  ‖P₄ − P₁‖ → 0

in units in which P0 = I. Whatever the noise, P₄ − P₁ ≥ 3 Φ n nᵀ Φᵀ for unobservable n with nᵀ P0⁻¹ n = 1
(dP/dc = M_c P0 M_cᵀ, M_c n = Φ n, from c P0): the two never come closer than hidden errors shrink.

The covariance is carried as a square root, P = L Lᵀ, from sample to sample:

    (Φ L   M) = (L⁻  0) Q',   M Mᵀ = ∫ Φ G Q Gᵀ Φᵀ the driving noise of the step, by Gauss–Legendre
    (R^½  H L⁻)      (*  0  )
    (0      L⁻) = Q' (*  L⁺ )     by columns

References
----------
M. S. Grewal, A. P. Andrews, Kalman Filtering (2008), 6.5 (square-root filters).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from obscli.model.system import System
from obscli.numeric.collocation import gauss_legendre
from obscli.numeric.discrete_steps import single_steps
from obscli.numeric.driving_noise import driving_rate
from obscli.numeric.errors import NotComputableError
from obscli.numeric.finding import CrossCheck
from obscli.numeric.hidden_motion import transitions, units_of
from obscli.numeric.noise import NoiseModel, continuous_noise, steps_of
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import Array
from obscli.numeric.rates import rates_of
from obscli.numeric.settings import Effort
from obscli.numeric.transition import edges_of, longest_step


#: Samples where the noise is given as a density, and how many there may be.
_SAMPLES: Final = 400
_MOST: Final = 20_000
_STEP_ERROR: Final = 1e-12
_PROBES: Final = 18

#: At so many instants driving noise enters within a panel, in which G turns by so many radians at the most.
_NODES: Final = 5
_MOST_PHASE: Final = 1.0

_WIDER: Final = 4.0

#: How many instants are shown, the first and the last among them.
_SHOWN: Final = 7


def cross_check(system: System, start: float, stop: float) -> CrossCheck:
    """Solve the Riccati equation of the Kalman filter from P0 and 4 P0.

    Raises
    ------
    NotComputableError
        where there is no noise of the outputs, or too many samples
    """
    numeric = NumericSystem(system, start, stop)
    noise = continuous_noise(numeric)
    instants, step = samples_of(system, start, stop)
    P0, assumed = prior_of(system, noise)
    first: Array = np.asarray(np.linalg.cholesky(P0), dtype=float)
    found = [covariances(noise, start, instants, step, factor * first) for factor in (1.0, _WIDER**0.5)]
    times = np.concatenate([[start], instants])
    shown = np.unique(np.round(np.linspace(0, len(instants), _SHOWN)).astype(int))
    narrow, wide = ([found[i][k] for k in shown] for i in (0, 1))
    return CrossCheck(
        tuple(float(times[k]) for k in shown),
        _by_state(system, narrow),
        _by_state(system, wide),
        tuple(_apart(a, b, first) for a, b in zip(narrow, wide, strict=True)),
        assumed,
    )


def samples_of(system: System, start: float, stop: float) -> tuple[Array, float]:
    """Return the instants after the start at which outputs are taken, and the time between them.

    All outputs are taken as often as the one that is sampled most often, each as its density has it.
    """
    step = min((one for one in steps_of(system) if one is not None), default=(stop - start) / _SAMPLES)
    count = int((stop - start) / step * (1 + 1e-12))
    if not 0 < count <= _MOST:
        raise NotComputableError(
            f"{count} samples on the interval: between 1 and {_MOST} can be cross-checked"
        )
    instants: Array = start + step * np.arange(1.0, count + 1)
    return instants, step


def prior_of(system: System, noise: NoiseModel) -> tuple[Array, tuple[str, ...]]:
    """Return P0 with the units of the states where the file gives no prior, and the names of these."""
    P0: Array = noise.P0.copy()
    missing = np.diag(P0) == 0
    P0[missing, missing] = units_of(system)[missing] ** 2
    names = zip(system.state_names, missing, strict=True)
    return P0, tuple(name for name, absent in names if absent)


def covariances(noise: NoiseModel, start: float, instants: Array, step: float, root: Array) -> list[Array]:
    """Return P at the start, after its sample, and after each of the samples."""
    system = noise.system
    if system.system.discrete:
        return _step_by_step(noise, start, instants, root)
    outputs = system.matrices(np.concatenate([[start], instants]))[1]
    whitened = noise.whitening @ outputs * np.sqrt(step)
    rates = rates_of(system, np.linspace(start, instants[-1], _PROBES)[1:-1])
    longest = min(longest_step(rates), _MOST_PHASE / max(driving_rate(noise, instants), 1e-300))
    edges = edges_of(start, instants, longest, _MOST)
    noises = _entering(noise, edges)
    edges = np.union1d(edges, list(noises))
    root = _updated(root, whitened[0])
    found = [root]
    for phi, end in transitions(system, edges, Effort(_STEP_ERROR, _MOST * (_NODES + 1))):
        root = np.asarray(np.linalg.solve(phi, root), dtype=float)
        if end in noises:
            root = _lower(np.concatenate([root, noises[end]], axis=1))
        if end == instants[len(found) - 1]:
            root = _updated(root, whitened[len(found)])
            found.append(root)
    return _squared(found, np.concatenate([[start], instants]))


def _step_by_step(noise: NoiseModel, start: float, instants: Array, root: Array) -> list[Array]:
    """Return P of a discrete-time system after the sample of each step, from the start on."""
    k = np.concatenate([[start], instants])
    found: list[Array] = []
    for _, F, H, entered in single_steps(noise.system, noise, k):
        if entered is not None:
            root = _lower(np.concatenate([root, entered], axis=1))
        root = _updated(root, noise.whitening @ H)
        found.append(root)
        root = F @ root
    return _squared(found, k)


def _entering(noise: NoiseModel, edges: Array) -> dict[float, Array]:
    """Return the instants at which driving noise enters, and square roots of how much: √w_j G Q^½."""
    if noise.drive is None:
        return {}
    rule = gauss_legendre(_NODES)
    h = np.diff(edges)
    t = (edges[:-1, None] + h[:, None] * rule.nodes).ravel()
    sizes = np.sqrt(h[:, None] * rule.weights).ravel()
    return dict(zip(t.tolist(), sizes[:, None, None] * noise.driving(t), strict=True))


def _squared(roots: Sequence[Array], instants: Array) -> list[Array]:
    """Return L Lᵀ of each."""
    with np.errstate(over="ignore", invalid="ignore"):
        found = [one @ one.T for one in roots]
    for P, t in zip(found, instants, strict=True):
        if not np.isfinite(P).all():
            raise NotComputableError(
                f"the covariance is beyond all numbers at {t:.6g}: choose a shorter interval (--to)"
            )
    return found


def _updated(root: Array, rows: Array) -> Array:
    """Return the square root of P after an output y = rows x + v with E v vᵀ = I."""
    m, n = rows.shape
    joint = np.block([[np.eye(m), rows @ root], [np.zeros((n, m)), root]])
    return _lower(joint)[m:, m:]


def _lower(matrix: Array) -> Array:
    """Return a lower triangular L, shape (k, k), with L Lᵀ = M Mᵀ for M (k, …)."""
    triangle: Array = np.linalg.qr(matrix.T, mode="r")  # type: ignore[assignment]  # no QRResult in this mode
    return triangle.T


def _by_state(system: System, covariances: list[Array]) -> dict[str, tuple[float, ...]]:
    deviations = np.sqrt(np.array([np.diag(P) for P in covariances]))
    return {name: tuple(map(float, deviations[:, j])) for j, name in enumerate(system.state_names)}


def _apart(narrow: Array, wide: Array, first: Array) -> float:
    """Return how far covariances are apart where P0 = L₀ L₀ᵀ is I, 1 for P0 and 4 P0."""
    inverse = np.linalg.inv(first)
    difference = inverse @ (wide - narrow) @ inverse.T
    largest = float(np.linalg.eigvalsh((difference + difference.T) / 2)[-1])
    return float(np.sqrt(max(largest, 0.0) / (_WIDER - 1)))
