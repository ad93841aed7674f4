"""Values of functions moved onto the relations they satisfy, by the shortest way (Gauss–Newton).

f ← f − Jᵀ (J Jᵀ)⁺ g(f),    g the relations, J = ∂g/∂f
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from obscli.numeric.errors import NotComputableError
from obscli.numeric.program import Array, Program, Value


_STEPS: Final = 50
_DIFFERENCE: Final = 1e-7

#: Relations are satisfied to this, relative to the size of the functions.
RESIDUAL: Final = 1e-15
_ENOUGH: Final = 1e-13


def onto_relations(
    relations: Program, names: Sequence[str], start: Array, values: Mapping[str, Value]
) -> Array:
    """Return values of the named functions, near ``start``, at which all relations vanish.

    Parameters
    ----------
    relations : the relations g, one root each
    names : the functions that may be changed
    start : shape (len(names), k), at k instants
    values : everything else that the relations name

    Raises
    ------
    NotComputableError
        where no such values are found
    """
    f = np.array(start)

    def residual(f: Array) -> Array:
        found = relations.run({**values, **dict(zip(names, f, strict=True))})
        return np.array([np.broadcast_to(one, f.shape[1:]) for one in found])

    best, worst = f, np.inf
    for _ in range(_STEPS):
        g = residual(f)
        size = np.abs(g).max(initial=0.0) / (1 + np.abs(f).max(initial=0.0))
        if not np.isfinite(size):
            break
        if size < worst:
            best, worst = f, size
        elif worst <= _ENOUGH:
            break
        if worst <= RESIDUAL / 4:
            break
        J = np.empty((f.shape[1], len(g), len(f)))
        for k in range(len(f)):
            h = _DIFFERENCE * (1 + np.abs(f[k]))
            moved = f.copy()
            moved[k] += h
            J[:, :, k] = ((residual(moved) - g) / h).T
        f = f - np.einsum("kji,ik->jk", np.linalg.pinv(J, rcond=1e-9), g)
    if worst <= _ENOUGH:
        return best
    raise NotComputableError(
        "no sample motion was found that satisfies the relations of the file's functions; "
        "fix the functions to a motion, e.g. --fix f=sin(t)"
    )
