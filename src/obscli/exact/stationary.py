"""Reducible systems: stationary systems in new variables, found by algorithm.

    z = V(t) x,   z' = A_z z,   y = H_z z     with     V' + V A = A_z V,   H = H_z V

References
----------
Morozov & Baklanov 2018, section 5, (13)–(22).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from obscli.exact.errors import UndecidedError


if TYPE_CHECKING:
    from obscli.exact.lift_finding import NotReducible, Stationary
    from obscli.exact.prove import Proof


def stationary_of(proof: Proof) -> Stationary | NotReducible:
    """Return the stationary systems that a system of proved rank reduces to, or what stands in the way.

    Raises
    ------
    UndecidedError : the coefficients grow too large
    """
    del proof
    raise UndecidedError("stationary systems are not searched yet")
