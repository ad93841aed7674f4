"""The observability matrix M(t) of a subject, in an orthonormal basis of its rows, in scaled units.

    M_s = M D = C U,   x = D x_s

The values are certain: balls, at whatever precision it takes for them and for Cᵀ C. Functions left open
follow the sample motion.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

import numpy as np
from flint import arb, arb_mat

from obscli.exact.ball import OutsideDomainError, precision
from obscli.exact.errors import UndecidedError
from obscli.exact.exact_system import read_system
from obscli.exact.local_matrix import local_matrix, series_length
from obscli.exact.lower import used_names
from obscli.measures.measure import NotMeasuredError
from obscli.measures.orthogonal_rows import ImpreciseError, OrthogonalRows, orthogonalised
from obscli.model.expression import Expression
from obscli.model.system import System
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import Array, jet


#: Bits of the balls, in the order tried.
PRECISIONS: Final = (400, 1000, 4000, 16000)

#: M has m n rows of n entries; so many in all are worked on.
_MOST_ENTRIES: Final = 300_000


@dataclass(frozen=True, slots=True, eq=False)
class Local:
    """M(t) D = C U at an instant.

    Parameters
    ----------
    rows : of M D, level after level, outputs in order within a level
    origins : level and output of every row
    orthogonal : C, U, residuals
    bits : the precision that it took
    """

    rows: arb_mat
    origins: tuple[tuple[int, int], ...]
    orthogonal: OrthogonalRows
    bits: int


def local(numeric: NumericSystem, there: System, rank: int, at: float, units: Array) -> Local:
    """Return the observability matrix at an instant, orthogonalised.

    Parameters
    ----------
    numeric : the system in floating point, which knows the sample motion
    there : the system with its parameters replaced by their values
    rank : of the system, known exactly
    at : the instant
    units : D, shape (n,)

    Raises
    ------
    NotMeasuredError
        where M does not exist at the instant, is too large, or has a lower rank there
    """
    n = there.n
    if there.m * n * n > _MOST_ENTRIES:
        raise NotMeasuredError(
            f"the matrix of {n} states and {there.m} outputs is too large for this measure"
        )
    definitions = _definitions(there)
    values = _point(numeric, there, at, frozenset(definitions))
    origins = tuple((k, output) for k in range(n) for output in range(there.m))
    reached = -1
    for bits in PRECISIONS:
        try:
            blocks = local_matrix(there, values, bits, definitions)
        except OutsideDomainError:
            raise NotMeasuredError(
                f"a coefficient does not exist at {there.time} = {at:.6g}: choose another instant (--at)"
            ) from None
        with precision(bits, 1):
            D = [arb(float(one)) for one in units]
            rows = [[entry * d for entry, d in zip(row, D, strict=True)] for block in blocks for row in block]
            try:
                found = orthogonalised(rows, rank)
            except ImpreciseError:
                continue
            reached = found.rank
            if found.rank == rank and found.survives_squaring:
                matrix = arb_mat(len(rows), n, [entry for row in rows for entry in row])
                return Local(matrix, origins, found, bits)
    if reached == rank:
        raise NotMeasuredError(
            f"the observability matrix at {there.time} = {at:.6g} is too ill-conditioned for "
            f"{PRECISIONS[-1]} bits: choose other units of the states (--scaling), or another instant (--at)"
        )
    raise NotMeasuredError(
        f"the {n} blocks of the observability matrix are of a lower rank than {rank} at {there.time} = "
        f"{at:.6g}, or too near it: choose another instant (--at)"
    )


def _definitions(there: System) -> Mapping[str, Expression]:
    """Return the functions that relations give by the others."""
    if there.discrete:
        return {}
    try:
        return read_system(there).interpreter.definitions
    except UndecidedError as error:
        raise NotMeasuredError(str(error)) from None


def _point(numeric: NumericSystem, there: System, at: float, defined: frozenset[str]) -> dict[str, Fraction]:
    """Return time, and the functions in use with their derivatives along the sample motion, exactly."""
    names = used_names(there) - defined
    orders = {
        f.name: series_length(there) if f.derivative is None else 0
        for f in there.functions
        if f.name in names
    }
    signals = numeric.motion.signals if numeric.motion else None
    rough = [name for name in orders if signals is not None and name in signals.names]
    if rough:
        raise NotMeasuredError(
            f"the matrix at one instant needs all derivatives of {', '.join(rough)}, and samples of a signal "
            "do not tell them: measures of an interval do without"
        )
    sampled = numeric.values(np.array([at]), orders)
    keys = [jet(name, k) for name, top in orders.items() for k in range(top + 1)]
    return {there.time: Fraction(at), **{key: _exact(sampled[key]) for key in keys}}


def _exact(value: float | Array) -> Fraction:
    return Fraction(float(np.ravel(value)[0]))


def as_matrix(rows: Sequence[Sequence[float]] | Array, columns: int) -> arb_mat:
    """Return numbers as exact balls."""
    found = np.asarray(rows, dtype=float).reshape(-1, columns)
    return arb_mat(len(found), columns, [arb(float(entry)) for entry in found.ravel()])
