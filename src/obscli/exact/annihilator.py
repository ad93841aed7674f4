"""The least polynomial that annihilates the rows of H: how many functions of time the outputs consist of.

    H μ(A) = 0,   μ(s) = s^d + μ_{d−1} s^{d−1} + … + μ_0,   d least

The blocks H A^k, each written as one vector of length m n, are made independent one after the other; beside
each stands which one it was, so that the first dependence leaves the coefficients of μ. μ divides the
minimal polynomial of A, and is the one of A on what the outputs see.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from obscli.exact.echelon import Echelon, polynomial_row
from obscli.exact.field import Element
from obscli.exact.polynomial import require_small
from obscli.exact.tower import tower


if TYPE_CHECKING:
    from obscli.exact.exact_system import ExactSystem, Row

#: d² m n above this would take more than about a second.
_MOST_OPERATIONS: Final = 100_000


@dataclass(frozen=True, slots=True, eq=False)
class Annihilator:
    """μ by rising degree, monic, and the blocks H A^k, k < d."""

    coefficients: tuple[Element, ...]
    blocks: tuple[tuple[Row, ...], ...]


def annihilator(exact: ExactSystem) -> Annihilator:
    """Return μ of a time-invariant system.

    Raises
    ------
    UndecidedError : the system or its coefficients are too large
    """
    field, width = exact.field, len(exact.H) * exact.n
    echelon = Echelon(field, range(width + exact.n + 1))
    blocks: list[tuple[Row, ...]] = []
    for k, block in enumerate(tower(exact)):
        require_small(k * k * width, _MOST_OPERATIONS)
        vector = {i * exact.n + j: entry for i, row in enumerate(block) for j, entry in row.items()}
        rest = echelon.reduce(polynomial_row(field, {**vector, width + k: field.one}))
        if min(rest) >= width:
            break
        echelon.insert(echelon.strip(rest))
        blocks.append(block)
    tail = [rest.get(width + j, field.zero.num) for j in range(k + 1)]
    lead = Element(field, tail[-1], field.one_polynomial)
    return Annihilator(tuple(Element(field, c, field.one_polynomial) / lead for c in tail), tuple(blocks))
