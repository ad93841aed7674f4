"""The observability matrix at one instant, in ball arithmetic, straight from the model.

    M(t) = (L_0; L_1; …; L_{n−1}),   L_0 = H,   L_{k+1} = L_k' + L_k A

Bagmut 2009, (10), (11), with the dots of (10) that the print lost.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

from flint import arb

from obscli.exact.ball import BallPoint, precision
from obscli.exact.lower import differentiated, highest_derivative, series_rows
from obscli.exact.sample_window import sample_window


if TYPE_CHECKING:
    from collections.abc import Mapping
    from fractions import Fraction

    from obscli.model.expression import Expression
    from obscli.model.system import System

#: Rows of M by order, then by output: each n balls.
Blocks: TypeAlias = tuple[tuple[tuple[arb, ...], ...], ...]


def local_matrix(
    system: System,
    values: Mapping[str, Fraction],
    bits: int,
    definitions: Mapping[str, Expression] | None = None,
) -> Blocks:
    """Return L_0 … L_{n−1} at a point.

    Parameters
    ----------
    system : with the parameters replaced by their values
    values : of time, and of the functions with as many derivatives as ``series_length`` says
    bits : precision of the balls
    definitions : functions given by a relation as expressions of the others

    Raises
    ------
    OutsideDomainError : some coefficient does not exist at the point
    """
    if system.discrete:
        return _of_samples(system, values, bits)
    length = series_length(system)
    with precision(bits, length):
        point = BallPoint(system, values, length, definitions)
        A, rows = series_rows(point, system.A), series_rows(point, system.H)
        found = []
        for k in range(system.n):
            if k:
                rows = [differentiated(row, A) for row in rows]
            found.append(tuple(_dense({j: one[0] for j, one in row.items()}, system.n) for row in rows))
        return tuple(found)


def _of_samples(system: System, values: Mapping[str, Fraction], bits: int) -> Blocks:
    """Return the blocks of a discrete-time system: the rows of n samples in the state at the first."""
    window = sample_window(system)
    with precision(bits, 1):
        point = BallPoint(window, values, 1)
        rows = [_dense({j: e[0] for j, e in row.items()}, system.n) for row in series_rows(point, window.H)]
        return tuple(tuple(rows[j * system.m : (j + 1) * system.m]) for j in range(system.n))


def series_length(system: System) -> int:
    """Return how many terms of every coefficient's series M depends on."""
    return system.n + highest_derivative(system)


def _dense(row: Mapping[int, arb], n: int) -> tuple[arb, ...]:
    return tuple(row.get(j, arb(0)) for j in range(n))
