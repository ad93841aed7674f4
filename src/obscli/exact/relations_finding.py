"""The method of unobservable states: relations f(t) dᵀx0 = 0 that hold exactly if no output shows x0.

    y_i(t) = Σ_j f_j(t) d_ijᵀ x0        f_j linearly independent, so y = 0 exactly if all d_ijᵀ x0 are 0

References
----------
V. I. Kortunov, G. A. Proskura (2006), (4)-(7).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias

from obscli.model.expression import Expression
from obscli.model.system import Covector


#: 1: some relations give the state alone; 2: they tie it to others; 3: it is in none of them.
Situation: TypeAlias = Literal[1, 2, 3]


@dataclass(frozen=True, slots=True, eq=False)
class Relation:
    """One term f(t) dᵀx0 of an output.

    Parameters
    ----------
    function : f, of the time since ``Relations.instant``
    output : the output it is a term of
    coefficients : d
    combination : d up to a factor, as it reads best
    independent : whether d is independent of those of the relations before it
    """

    function: Expression
    output: str
    coefficients: Covector
    combination: Covector
    independent: bool


@dataclass(frozen=True, slots=True, eq=False)
class Canonical:
    """Functions φ_0 … φ_{k−1} without a shorter form: q(d/dt) φ_i = 0, φ_i^(j)(0) = δ_ij, j < k.

    ``names``: the symbols that stand for them; ``polynomial``: the coefficients of q by rising degree, monic.
    """

    names: tuple[str, ...]
    polynomial: tuple[Expression, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Relations:
    """All relations of a system, and what they say of each state by itself.

    Parameters
    ----------
    exact : whether the outputs are exactly the sum of the terms (time-invariant systems); else the terms
        are the first ones of a power series
    relations : the terms with d ≠ 0, function by function, then output by output
    situations : of each state
    canonical : what names of functions stand for that the grammar has no form for
    instant : of x0: a number, or the symbol of an instant left open; None: t is counted from it
    differing : states whose situation at this instant is not their verdict at almost every other one
    notes : on what the form of the functions rests
    """

    exact: bool
    relations: tuple[Relation, ...]
    situations: Mapping[str, Situation]
    canonical: tuple[Canonical, ...] = ()
    instant: Expression | None = None
    differing: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
