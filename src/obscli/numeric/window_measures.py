"""How well linear forms of the state are observable within a window, from the singular values of its matrix.

With R D = U Σ Vᵀ in the units D of the states and a covector c of unit length in these units:

    equivalent singular value   σ̃ = Σ μ_i σ_i,  μ_i = (c v_i)²:  c (RᵀR)^½ cᵀ;  "abs": μ_i ∝ |c v_i|
    column norm                 |R D cᵀ|
    residual index              d = min |R D x| over c x = 1:  1/d² = Σ_i (c v_i)²/σ_i²;  0: not identifiable
    conventional rule           σ_i goes to the state with the largest |v_ki|; the largest that a state gets
    posterior ratio             p² = c (I + BᵀB)⁻¹ cᵀ,  B = W R P0^½, c of unit length in units of the prior

σ̃ is an average gain and no test: it is positive also where d is 0. Singular vectors of σ = 0 count in μ.

References
----------
Dong Jinlong, Mo Bo, (12), with μ_ki = v_ki²; Wan, Fang, Liu for the conventional rule.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Final, Literal, TypeAlias

import numpy as np

from obscli.numeric.program import Array, Counts, Flags
from obscli.numeric.subspace import Subspaces


#: How singular values are weighed: by squares, a function of R; by sizes, a habit.
Weights: TypeAlias = Literal["squared", "abs"]

#: Singular values nearer to each other, relative to the larger, turn their vectors at the least cause.
ALIKE: Final = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class WindowValues:
    """Values of k windows; those of q linear forms have the shape (k, q), states first.

    Parameters
    ----------
    t : starts, shape (k,)
    rank, decided, gap : of the matrix of each, shape (k,)
    singular_values : shape (k, n)
    equivalent, column_norm, residual : as in this module
    conventional : of the n states; not a number where a state gets none, shape (k, n)
    posterior : not a number where there is no prior or no noise
    degenerate : whether some singular values cannot be told apart, shape (k,)
    """

    t: Array
    rank: Counts
    decided: Flags
    gap: Array
    singular_values: Array
    equivalent: Array
    column_norm: Array
    residual: Array
    conventional: Array
    posterior: Array
    degenerate: Flags

    def at(self, windows: Counts) -> WindowValues:
        """Return the values of some windows."""
        return WindowValues(*(getattr(self, one.name)[windows] for one in fields(self)))


def joined(parts: Sequence[WindowValues]) -> WindowValues:
    """Return the values of consecutive windows in one."""
    names = [one.name for one in fields(WindowValues)]
    return WindowValues(*(np.concatenate([getattr(one, name) for one in parts]) for name in names))


def window_values(
    spaces: Subspaces, forms: Array, weights: Weights, informed: tuple[Array, Array] | None
) -> WindowValues:
    """Return the values of windows.

    Parameters
    ----------
    spaces : R D decomposed
    forms : covectors in the file's units, states first, shape (k, q, n)
    informed : roots T of P0^½ RᵀWᵀW R P0^½ and P0^½ itself, (k, n, n) and (n, n); None: no prior or no noise
    """
    unit = _of_unit_length(forms * spaces.gramian.units[:, None, :])
    along = unit @ np.swapaxes(spaces.right, 1, 2)
    return WindowValues(
        t=spaces.gramian.starts,
        rank=spaces.rank,
        decided=spaces.decided,
        gap=spaces.gap,
        singular_values=spaces.values,
        equivalent=_equivalent(along, spaces.values, weights),
        column_norm=np.linalg.norm(spaces.gramian.matrices @ np.swapaxes(unit, 1, 2), axis=1),
        residual=residual_index(spaces, along),
        conventional=_conventional(spaces),
        posterior=np.full(unit.shape[:2], np.nan) if informed is None else _posterior(forms, *informed),
        degenerate=_degenerate(spaces),
    )


def identifiable(spaces: Subspaces, along: Array) -> Flags:
    """Return whether linear forms vanish on the kernel, to what is known of it.

    Parameters
    ----------
    along : components c v_i of covectors of unit length, shape (k, q, n)
    """
    hidden = np.arange(spaces.n) >= spaces.rank[:, None]
    outside = np.sqrt(((along**2) * hidden[:, None, :]).sum(axis=2))
    within: Flags = (outside <= spaces.kernel_angle[:, None]) & (spaces.rank > 0)[:, None]
    return within


def residual_index(spaces: Subspaces, along: Array) -> Array:
    """Return d of linear forms, shape (k, q); exactly 0 where the form is not identifiable."""
    shown = np.arange(spaces.n) < spaces.rank[:, None]
    inverse = np.where(shown, 1 / np.where(shown, spaces.values, 1.0) ** 2, 0.0)
    squared = ((along**2) * inverse[:, None, :]).sum(axis=2)
    with np.errstate(divide="ignore"):
        found: Array = np.where(identifiable(spaces, along), 1 / np.sqrt(squared), 0.0)
    return found


def _equivalent(along: Array, values: Array, weights: Weights) -> Array:
    mu = along**2 if weights == "squared" else np.abs(along)
    found: Array = (mu * values[:, None, :]).sum(axis=2) / mu.sum(axis=2)
    return found


def _conventional(spaces: Subspaces) -> Array:
    k, n = spaces.values.shape
    found = np.full((k, n), np.nan)
    largest = np.abs(spaces.right).argmax(axis=2)
    window = np.arange(k)
    for i in range(n):  # the largest singular value first: a state keeps what it has
        to = largest[:, i]
        free = np.isnan(found[window, to]) & (i < spaces.rank)
        found[window[free], to[free]] = spaces.values[free, i]
    return found


def _posterior(forms: Array, root: Array, prior: Array) -> Array:
    """Return p of linear forms, given T and P0^½."""
    _, values, right = np.linalg.svd(root)
    along = _of_unit_length(forms @ prior) @ np.swapaxes(right, 1, 2)
    found: Array = np.sqrt(((along**2) / (1 + values**2)[:, None, :]).sum(axis=2))
    return found


def _degenerate(spaces: Subspaces) -> Flags:
    """Return whether two singular values agree, the zeros of the kernel among them."""
    values, n = spaces.values, spaces.n
    shown = np.arange(1, n) < spaces.rank[:, None]
    alike = (values[:, :-1] - values[:, 1:] <= ALIKE * values[:, :-1]) & shown
    found: Flags = alike.any(axis=1) | (spaces.rank <= n - 2)
    return found


def _of_unit_length(forms: Array) -> Array:
    size = np.linalg.norm(forms, axis=2, keepdims=True)
    return np.asarray(forms / np.where(size > 0, size, 1.0), dtype=float)
