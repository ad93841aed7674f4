"""The distinct eigenvalues of a constant matrix, each with how often it occurs.

    det(λ I − A) = Π p_k(λ)^k,   p_k without multiple roots:   each root of p_k occurs k times

Over rational numbers the polynomial and its factors are exact, and roots are isolated however far apart their
sizes are. Entries such as √2 or π are balls. A k-fold eigenvalue of these scatters by about ‖A‖ 2^(−bits/k);
what lies within ‖A‖ 2^(−bits/2n), k ≤ n, is taken as one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import cast

from flint import acb, acb_mat, arb, ctx, fmpq, fmpq_mat

from obscli.model.expression import Expression, Number


@dataclass(frozen=True, slots=True, eq=False)
class ModeValue:
    """An eigenvalue, and how often it occurs."""

    value: acb
    count: int


def mode_values(entries: Mapping[tuple[int, int], Expression], A: acb_mat) -> list[ModeValue]:
    """Return the distinct eigenvalues; use inside ``precision``.

    Parameters
    ----------
    entries : of the matrix, those not given are zero
    A : their values to the precision in force, in whatever units of the states
    """
    return _roots(entries, A.nrows()) if is_rational(entries) else _clusters(A)


def is_rational(entries: Mapping[tuple[int, int], Expression]) -> bool:
    """Whether all entries are rational numbers."""
    return all(isinstance(one, Number) for one in entries.values())


def _roots(entries: Mapping[tuple[int, int], Expression], n: int) -> list[ModeValue]:
    matrix = fmpq_mat(n, n)
    for (i, j), entry in entries.items():
        assert isinstance(entry, Number)
        matrix[i, j] = fmpq(entry.value.numerator, entry.value.denominator)
    roots = cast("list[tuple[acb, int]]", matrix.charpoly().numer().complex_roots())
    return [ModeValue(acb(root).mid(), int(count)) for root, count in roots]


def _clusters(A: acb_mat) -> list[ModeValue]:
    """Return eigenvalues in groups, the mean of each: it is as accurate as a simple eigenvalue."""
    size = largest(A)
    apart = size * arb(2) ** -(ctx.prec // (2 * max(A.nrows(), 1)))
    groups: list[list[acb]] = []
    for value in A.eig(algorithm="approx"):
        near = [g for g in groups if any(abs(value - one) <= apart for one in g)]
        joined = [value.mid(), *(one for g in near for one in g)]
        groups = [g for g in groups if g not in near] + [joined]
    return [ModeValue(_clean(sum(group, acb(0)) / len(group), size), len(group)) for group in groups]


def _clean(value: acb, size: arb) -> acb:
    """Return an eigenvalue without what is rounding: a real one is real, zero is zero."""
    tiny = size * arb(2) ** -(ctx.prec // 4)
    real, imag = (part.mid() for part in (value.real, value.imag))
    return acb(real if abs(real) > tiny else 0, imag if abs(imag) > tiny else 0)


def largest(A: acb_mat) -> arb:
    """Return the size of the largest entry."""
    return max((abs(entry).mid() for entry in A.entries()), default=arb(0))
