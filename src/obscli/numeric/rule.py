"""Functions given by rules f' = F(f, t), integrated by collocation and kept as piecewise polynomials.

On each panel [a, a + h] with nodes τ_j the iteration  f_j ← f(a) + h Σ_l (w_l − B_jl) F(f_l, τ_l)  runs until
it stands; the panel is halved where it does not, or where the last coefficients of F do not fade.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np
from numpy.polynomial import legendre

from obscli.model.expression import Expression
from obscli.numeric.collocation import gauss_legendre
from obscli.numeric.errors import NotComputableError
from obscli.numeric.program import Array, Program, Value


Given: TypeAlias = Callable[[Array], Mapping[str, Value]]

_NODES: Final = 16
_SWEEPS: Final = 60
_TOLERANCE: Final = 1e-15
_MOST_PANELS: Final = 20_000


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """Functions as polynomials on panels: ``edges`` (p + 1,), ``coefficients`` (p, s + 1, q) of Legendre."""

    names: tuple[str, ...]
    edges: Array
    coefficients: Array

    @property
    def error(self) -> float:
        """The relative error to be expected: that of every panel, added up."""
        return _TOLERANCE * len(self.coefficients)

    def values(self, t: Array) -> dict[str, Value]:
        """Return the functions at instants within the interval."""
        k = np.clip(np.searchsorted(self.edges, t, side="right") - 1, 0, len(self.edges) - 2)
        u = 2 * (t - self.edges[k]) / (self.edges[k + 1] - self.edges[k]) - 1
        basis = legendre.legvander(u, self.coefficients.shape[1] - 1)
        found = np.einsum("ks,ksq->qk", basis, self.coefficients[k])
        return dict(zip(self.names, found, strict=True))


def solve_rules(
    rules: Mapping[str, Expression], initial: Array, given: Given, start: float, stop: float
) -> Solution:
    """Return the functions over an interval.

    Parameters
    ----------
    rules : F by name of function
    initial : the values at ``start``, shape (q,)
    given : everything else that the rules name, at instants

    Raises
    ------
    NotComputableError
        where the functions run away or change too fast
    """
    names = tuple(rules)
    program = Program(tuple(rules.values()))
    edges, coefficients = [start], []
    f, h = np.asarray(initial, dtype=float), (stop - start) / 8
    while edges[-1] < stop:
        a = edges[-1]
        h = min(h, stop - a)
        found = _panel(program, names, f, given, a, h)
        if found is None:
            h /= 2
            if h < 1e-9 * (stop - start) or len(edges) > _MOST_PANELS:
                raise NotComputableError(
                    f"{', '.join(names)}: the rules cannot be followed beyond t = {a:.6g}"
                )
            continue
        coefficients.append(found)
        f = found.sum(axis=0)  # every P_k is 1 at the end
        edges.append(stop if a + h >= stop * (1 - 1e-15) and h >= stop - a else a + h)
        h *= 1.6
    return Solution(names, np.array(edges), np.array(coefficients))


def _panel(
    program: Program, names: tuple[str, ...], f: Array, given: Given, a: float, h: float
) -> Array | None:
    """Return the Legendre coefficients (s + 1, q) of the functions on a panel, None where it is too long."""
    rule = gauss_legendre(_NODES)
    t = a + h * rule.nodes
    known = given(t)
    at_nodes = np.repeat(f[:, None], _NODES, axis=1)
    for _ in range(_SWEEPS):
        found = program.run({**known, **dict(zip(names, at_nodes, strict=True))})
        F = np.array([np.broadcast_to(one, t.shape) for one in found])
        with np.errstate(invalid="ignore", over="ignore"):
            after = f[:, None] + h * F @ rule.forward.T
        if not np.isfinite(after).all():
            return None
        change = np.abs(after - at_nodes).max()
        at_nodes = after
        if change <= 4 * _TOLERANCE * (1 + np.abs(after).max()):
            break
    else:
        return None
    spectrum = F @ rule.spectrum.T
    if np.abs(spectrum[:, -2:]).max() * h > 10 * _TOLERANCE * (1 + np.abs(at_nodes).max()):
        return None
    coefficients = np.asarray(legendre.legint(h / 2 * spectrum.T, lbnd=-1), dtype=np.float64)
    coefficients[0] += f
    return coefficients
