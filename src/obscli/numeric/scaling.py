"""Units of the states in which the rank is decided: the file's, the user's, or those of the Gramian itself.

Singular values change with the units of the states, the rank does not; good units make the gap clear.

    automatic   the columns of M get unit length (for W: unit diagonal), so that every state weighs alike
    scale       the typical sizes the file gives (`scale`)
    prior       the initial standard deviations (`noise: P0`, `P0_std`)
    none        as the file writes them
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, TypeAlias

import numpy as np

from obscli.model.expression import Expression
from obscli.model.system import System
from obscli.numeric.errors import NotComputableError, UnfitRequestError
from obscli.numeric.gramian import Gramian
from obscli.numeric.numeric_system import constants_of
from obscli.numeric.program import Array, constant_value


Given: TypeAlias = Literal["scale", "prior", "none"]
Scaling: TypeAlias = Literal["automatic"] | Given


def scaled(gramian: Gramian, system: System, scaling: Scaling) -> Gramian:
    """Return the Gramian in the units of a scaling.

    Raises
    ------
    UnfitRequestError
        where the file does not give the sizes asked for, for every state
    NotComputableError
        where one of them is not positive
    """
    if scaling == "automatic":
        return gramian.in_units(_equilibrating(gramian))
    return gramian.in_units(sizes_of(system, scaling) / gramian.units)


def sizes_of(system: System, scaling: Given) -> Array:
    """Return the sizes of the states that a scaling takes as units, shape (n,); raises as ``scaled``."""
    return np.ones(system.n) if scaling == "none" else _given(system, scaling)


def chosen_scaling(system: System, asked: Scaling | None) -> Scaling:
    """Return the scaling asked for; unasked, the file's sizes where it gives them for every state."""
    if asked is not None:
        return asked
    return "scale" if all(state.scale is not None for state in system.states) else "automatic"


def _equilibrating(gramian: Gramian) -> Array:
    """Return the factors 1/|column|; a column that is only noise gets the noise level of the others."""
    diagonal = np.einsum("ijj->ij", gramian.matrices)
    size = np.linalg.norm(gramian.matrices, axis=1) if gramian.is_root else np.sqrt(np.abs(diagonal))
    noise = np.sqrt(np.einsum("ijj->ij", gramian.error))
    if not gramian.is_root:
        return 1 / np.where(size > 0, size, 1.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        level = np.nanmin(np.where(size > 0, noise / size, np.nan), axis=1, initial=1.0)[:, None]
        size = np.maximum(size, noise / np.maximum(level, 1e-300))
    return 1 / np.where(size > 0, size, 1.0)


def _given(system: System, scaling: Given) -> Array:
    named: Mapping[str, Expression | None] = (
        {state.name: state.scale for state in system.states} if scaling == "scale" else system.prior
    )
    missing = [state.name for state in system.states if named.get(state.name) is None]
    if missing:
        where = "`scale` of the states" if scaling == "scale" else "`P0_std` under `noise`"
        raise UnfitRequestError(f"--scaling {scaling} needs {where}; missing for {', '.join(missing[:6])}")
    constants = constants_of(system)
    sizes = [constant_value(named[state.name], constants) for state in system.states]  # type: ignore[arg-type]
    bad = [s.name for s, size in zip(system.states, sizes, strict=True) if not 0 < size < np.inf]
    if bad:
        raise NotComputableError(f"--scaling {scaling}: the size of {', '.join(bad)} is not positive")
    return np.array(sizes)
