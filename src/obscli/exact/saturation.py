"""Which rows of the observability matrix are independent, and at which order it saturates.

    L_0 = H,  L_{k+1} = L_k' + L_k A,  rows taken by order k, then by output

A row of order k + 1 can be new only if its row of order k was; rows of a saturated order bring nothing
new ever after. Computed at one random point modulo a prime: the rows found are independent for certain,
that there are no more is proved afterwards by the kernel (``upper``).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flint import nmod_mat, nmod_poly

from obscli.exact.errors import JetOverflowError, UndecidedError
from obscli.exact.exact_system import more_jets
from obscli.exact.series import PRIME, BadPointError, SeriesPoint


if TYPE_CHECKING:
    from collections.abc import Mapping

    from obscli.exact.exact_system import ExactSystem, Row

_SEED = 20260117
_ATTEMPTS = 20


@dataclass(frozen=True, slots=True)
class Saturation:
    """Independent rows (order, output index) of L in order, the rank, the order at which L saturates."""

    rows: tuple[tuple[int, int], ...]
    order: int

    @property
    def rank(self) -> int:
        """The rank of the observability matrix."""
        return len(self.rows)


def saturate(
    exact: ExactSystem,
    *,
    frozen: bool = False,
    seed: int = _SEED,
) -> Saturation:
    """Return the independent rows of L; ``frozen``: of L_{k+1} = L_k A, A and H taken as constants."""
    length = 1 if frozen or not exact.varies else 6
    while True:
        try:
            return _saturate(exact, length, frozen=frozen, seed=seed)
        except _TooShortError:
            length *= 2
        except BadPointError:
            seed += 1


def rank_modulo_a_prime(exact: ExactSystem) -> int:
    """Return the rank of L at a random point modulo a prime, which the rank is not below.

    The system is read again with more derivatives of its functions where they run out.

    Raises
    ------
    UndecidedError : more derivatives would be needed than are tried
    """
    while True:
        try:
            return saturate(exact).rank
        except JetOverflowError:
            exact = more_jets(exact)


def independent_values(
    exact: ExactSystem,
    saturation: Saturation,
    seed: int = _SEED + 1,
    chosen: Mapping[int, int] | None = None,
) -> tuple[SeriesPoint, list[dict[int, int]]]:
    """Return a random point modulo PRIME and the values there of the independent rows of L."""
    length = saturation.order + 1 if exact.varies else 1
    while True:
        try:
            point = SeriesPoint(exact.field, length, seed, chosen)
            return point, _values(exact, saturation, point, length)
        except BadPointError:
            seed += 1
            if seed > _SEED + _ATTEMPTS:
                raise UndecidedError("no point was found at which the coefficients exist") from None


def _values(
    exact: ExactSystem, saturation: Saturation, point: SeriesPoint, length: int
) -> list[dict[int, int]]:
    A = [_series_row(point, row) for row in exact.A]
    known: dict[tuple[int, int], dict[int, nmod_poly]] = {}
    for order, output in saturation.rows:
        if order == 0:
            known[order, output] = _series_row(point, exact.H[output])
        else:
            row = known[order - 1, output]
            known[order, output] = _differentiate(row, A, length, constant=not exact.varies)
    return [{j: int(series[0]) for j, series in known[row].items()} for row in saturation.rows]


def stays_independent(
    exact: ExactSystem, saturation: Saturation, chosen: Mapping[int, int] | None = None
) -> bool:
    """Whether rows of L that are independent generically are so for this system, or at chosen values.

    True is certain (a minor that is nonzero modulo p); False is only a reason to look closer.
    """
    _, rows = independent_values(exact, saturation, chosen=chosen)
    matrix = nmod_mat(len(rows), exact.n, PRIME)
    for k, row in enumerate(rows):
        for j, value in row.items():
            matrix[k, j] = value
    rank: int = matrix.rank()
    return rank == saturation.rank


def rank_at_instant(exact: ExactSystem, rank: int, chosen: Mapping[int, int], seed: int = _SEED) -> int:
    """Return the rank of L_0 … L_{n-1} at one point modulo PRIME, at most ``rank``.

    At an isolated instant a row that depends on earlier ones may have derivatives that do not, so all
    orders of all outputs are taken.
    """
    orders = exact.n
    while True:
        try:
            point = SeriesPoint(exact.field, orders, seed, chosen)
            A = [_series_row(point, row) for row in exact.A]
            level = [_series_row(point, row) for row in exact.H]
            break
        except BadPointError:
            seed += 1
            if seed > _SEED + _ATTEMPTS:
                raise UndecidedError("no point was found at which the coefficients exist") from None
    echelon: dict[int, dict[int, int]] = {}
    for order in range(orders):
        for row in level:
            _insert(echelon, {j: int(series[0]) for j, series in row.items()})
        if len(echelon) == rank or order + 1 == orders:
            break
        level = [_differentiate(row, A, orders, constant=False) for row in level]
    return len(echelon)


class _TooShortError(Exception):
    """The series ran out of terms before the observability matrix saturated."""


def _saturate(exact: ExactSystem, length: int, *, frozen: bool, seed: int) -> Saturation:
    point = SeriesPoint(exact.field, length, seed)
    A = [_series_row(point, row) for row in exact.A]
    constant = frozen or not exact.varies
    echelon: dict[int, dict[int, int]] = {}
    level = {output: _series_row(point, row) for output, row in enumerate(exact.H)}
    found: list[tuple[int, int]] = []
    for order in range(exact.n + 1):
        fresh = {
            output: row
            for output, row in level.items()
            if _insert(echelon, {j: int(s[0]) for j, s in row.items()})
        }
        found += [(order, output) for output in fresh]
        if not fresh or len(found) == exact.n:
            break
        if not constant and order + 1 >= length:
            raise _TooShortError
        level = {o: _differentiate(row, A, length, constant=constant) for o, row in fresh.items()}
    return Saturation(tuple(found), max((order for order, _ in found), default=0))


def _series_row(point: SeriesPoint, row: Row) -> dict[int, nmod_poly]:
    return {j: point.value(element) for j, element in row.items()}


def _differentiate(
    row: dict[int, nmod_poly], A: list[dict[int, nmod_poly]], length: int, *, constant: bool
) -> dict[int, nmod_poly]:
    """Return l' + lA."""
    result = {} if constant else {j: series.derivative() for j, series in row.items()}
    for i, series in row.items():
        for j, entry in A[i].items():
            product = series.mul_low(entry, length)
            result[j] = result[j] + product if j in result else product
    return result


def _insert(echelon: dict[int, dict[int, int]], row: dict[int, int]) -> bool:
    """Reduce a row by an echelon form modulo PRIME (pivots 1); insert what remains, if anything."""
    row = {j: value for j, value in row.items() if value}
    while row:
        pivot = min(row)
        if pivot not in echelon:
            inverse = pow(row[pivot], -1, PRIME)
            echelon[pivot] = {j: value * inverse % PRIME for j, value in row.items()}
            return True
        factor = row[pivot]
        for j, value in echelon[pivot].items():
            rest = (row.get(j, 0) - factor * value) % PRIME
            if rest:
                row[j] = rest
            else:
                row.pop(j, None)
    return False
