"""Units in which the matrix of a window is weighed: states by the prior or `scale`, outputs by their noise.

    R_s = (I ⊗ W) R D,    W Rn Wᵀ = I,    D: deviations of P0, sizes, or 1

Rn is the covariance of one sample: as the file has it where it says how often there is one, else the density
divided by the time between samples.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from obscli.model.system import System
from obscli.numeric.errors import NotComputableError
from obscli.numeric.noise import noise_model, steps_of
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import Array
from obscli.numeric.scaling import sizes_of


#: Where units of the states come from.
Units: TypeAlias = Literal["prior", "scale", "none"]


@dataclass(frozen=True, slots=True, eq=False)
class WindowScaling:
    """The weights of states and outputs.

    Parameters
    ----------
    units : D, shape (n,)
    origin : where they come from
    whitening : W, shape (m, m)
    prior : P0^½, shape (n, n); None: not every state has a prior
    without_prior, without_noise : states without P0, outputs without R
    asked : whether the user asked for these units
    """

    units: Array
    origin: Units
    whitening: Array | None
    prior: Array | None
    without_prior: tuple[str, ...]
    without_noise: tuple[str, ...]
    asked: bool

    @property
    def weights(self) -> Array | None:
        """The weights of the outputs in R: none where units are asked for as in the file."""
        return None if self.origin == "none" and self.asked else self.whitening

    @property
    def is_informed(self) -> bool:
        """Whether prior and noise are known, so that deviations are."""
        return self.prior is not None and self.whitening is not None

    @property
    def is_of_prior(self) -> bool:
        """Whether R D is B = W R P0^½, so that one decomposition does."""
        return (
            self.origin == "prior"
            and self.prior is not None
            and self.weights is not None
            and np.allclose(self.prior, np.diag(self.units), rtol=1e-12, atol=0)
        )


def window_scaling(numeric: NumericSystem, asked: Units | None, h: float) -> WindowScaling:
    """Return the weights: those asked for, else the prior's, else the file's sizes, else none.

    Parameters
    ----------
    h : time between samples of outputs of which the file does not say how often

    Raises
    ------
    UnfitRequestError
        where the file does not give the units asked for
    NotComputableError
        where a covariance is not positive definite, …
    """
    system = numeric.system
    without_noise, without_prior = _without_noise(system), _without_prior(system)
    whitening = None if without_noise else _per_sample(numeric, h)
    prior = None if without_prior or without_noise else _root(numeric)
    origin: Units = asked or _origin(system, without_prior)
    units = sizes_of(system, origin)
    return WindowScaling(
        units, origin, whitening, prior, without_prior, without_noise, asked=asked is not None
    )


def _origin(system: System, without_prior: tuple[str, ...]) -> Units:
    if not without_prior:
        return "prior"
    return "scale" if all(one.scale is not None for one in system.states) else "none"


def _without_noise(system: System) -> tuple[str, ...]:
    R = system.noise.R if system.noise else None
    given = set() if R is None else {i for i, j in R.entries if i == j}
    return tuple(one.name for i, one in enumerate(system.outputs) if i not in given)


def _without_prior(system: System) -> tuple[str, ...]:
    return tuple(name for name in system.state_names if name not in system.prior)


def _per_sample(numeric: NumericSystem, h: float) -> Array:
    """Return W of one sample: that of the density times √(time between samples)."""
    if getattr(numeric.system, "discrete", False):
        return noise_model(numeric).whitening
    between = np.array([h if one is None else one for one in steps_of(numeric.system)])
    found: Array = noise_model(numeric).whitening * np.sqrt(between)
    return found


def _root(numeric: NumericSystem) -> Array:
    P0 = noise_model(numeric).P0
    if np.array_equal(P0, np.diag(np.diag(P0))):
        return np.diag(np.sqrt(np.diag(P0)))
    try:
        return np.asarray(np.linalg.cholesky(P0), dtype=float)
    except np.linalg.LinAlgError:
        raise NotComputableError("`noise: P0` is not positive definite") from None
