"""Transition matrices in ball arithmetic: the Taylor series of X' = A X with its remainder enclosed.

Around a, with A(a + s) = Σ A_k s^k and X(a) = I:

    (k + 1) X_{k+1} = Σ_{i ≤ k} A_i X_{k−i},    Φ(a + h, a) ∈ Σ_{k < K} X_k h^k + [X_K] h^K

The last term is the same recursion started from balls: A_k over all of [a, a + h], and for X_0 the bound
|X(s) − I| ≤ e^(h ‖A‖) − 1. Steps are halved until the remainder is small. The ends of a stretch may be balls
themselves (π/2 over a rate). Only the moving states' rows are worked on.

The rows H(a + s) Φ(a + s, a) have a Taylor series with the same coefficients and no remainder at all: they
span what is seen on any interval that begins at a, since everything is analytic.

References
----------
R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis (2009), ch. 9, 10.
F. Johansson (2017), Arb: efficient arbitrary-precision midpoint-radius interval arithmetic.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from typing import TYPE_CHECKING, Final

from flint import arb, arb_mat, arb_series, fmpq

from obscli.exact.ball import BallPoint, OutsideDomainError


if TYPE_CHECKING:
    from obscli.model.expression import Expression
    from obscli.model.system import Matrix, System


#: A stretch is not cut into more steps than so many.
MOST_STEPS: Final = 2000
_SMALLEST: Final = Fraction(1, 2**40)


class TooManyBallStepsError(Exception):
    """The remainder cannot be made small with so many steps."""


class BallTime(BallPoint):
    """Series of the expressions of a system at an instant that is a ball."""

    def __init__(self, system: System, t: arb, length: int) -> None:
        self._t = t
        super().__init__(system, {}, length)

    def _symbol(self, name: str) -> arb_series:
        return arb_series([self._t, 1]) if name == self._system.time else super()._symbol(name)


class BallSegment:
    """The motion of a system in ball arithmetic; use inside ``precision`` of more terms than ``terms``.

    Parameters
    ----------
    system : at the file's values, without functions left open
    terms : K, of the Taylor series
    """

    def __init__(self, system: System, terms: int) -> None:
        self._system = system
        self._terms = terms
        self._moving = sorted({i for i, _ in system.A.entries})
        self._row = {i: k for k, i in enumerate(self._moving)}

    def rows(self, t: arb, orders: int) -> list[arb_mat]:
        """Return the coefficients of s^k, k < orders (at most K), of H(t + s) Φ(t + s, t), each (m, n).

        Raises
        ------
        OutsideDomainError
            where a coefficient is not seen to exist
        KeyError
            naming a parameter or function without a value
        """
        orders = min(orders, self._terms)
        point = BallTime(self._system, t, orders + 1)
        X = self._series(point, self._identity(), orders)
        n, m = self._system.n, self._system.m
        H: list[arb_mat] = [arb_mat(m, n) for _ in range(orders)]
        for (i, j), entry in self._system.H.entries.items():
            for k, one in enumerate(_coefficients(point, entry, orders)):
                H[k][i, j] = one
        whole = [self._whole(own, first=not k) for k, own in enumerate(X)]
        moving = [i for i, own in enumerate(H) if i == 0 or not _is_zero(own)]
        return [_total(H[i] * whole[k - i] for i in moving if i <= k) for k in range(orders)]

    def transition(self, start: arb, duration: arb, tolerance: arb) -> arb_mat:
        """Return Φ(start + duration, start); every step's remainder is below the tolerance.

        Raises
        ------
        TooManyBallStepsError
            where that takes too many steps
        OutsideDomainError, KeyError
            as ``rows``
        """
        whole = self._unit()
        if not self._moving:
            return whole
        done, h, last = Fraction(0), _rational(duration), _rational(duration)
        for _ in range(MOST_STEPS):
            ends = done + h >= last
            step = duration - _exact(done) if ends else _exact(h)
            found = self._step(start + _exact(done), step, tolerance)
            if found is None:
                h = min(h, last - done) / 2
                if h < last * _SMALLEST:
                    raise TooManyBallStepsError
                continue
            whole = found * whole
            if ends:
                return whole
            done += h
        raise TooManyBallStepsError

    def _step(self, a: arb, h: arb, tolerance: arb) -> arb_mat | None:
        """Return Φ(a + h, a), None where the remainder is too large."""
        K = self._terms
        hull = a.union(a + h)
        try:
            wide = BallTime(self._system, hull, K + 1)
            A = self._coefficients_of(wide, 1)[0]
            growth = (h * _norm(A)).exp() - 1
            start = self._identity()
            for i in range(start.nrows()):
                for j in range(start.ncols()):
                    start[i, j] += growth * arb(0, 1)
            rest = self._series(wide, start, K + 1)[K]
        except OutsideDomainError:
            if h < tolerance:
                raise
            return None
        power = h**K
        for entry in rest.entries():
            if not (entry * power).abs_upper() < tolerance:
                return None
        X = self._series(BallTime(self._system, a, K), self._identity(), K)
        total = X[-1]
        for own in reversed(X[:-1]):
            total = total * h + own
        return self._whole(total + rest * power, first=True)

    def _series(self, point: BallTime, start: arb_mat, count: int) -> list[arb_mat]:
        """Return the moving rows of X_0 = start, X_1, …, so many."""
        A = self._coefficients_of(point, max(count - 1, 1))
        inner = {i: self._moving_columns(own) for i, own in enumerate(A) if not _is_zero(own)}
        still = [self._still_columns(own) for own in A]
        X = [start]
        for k in range(count - 1):
            total = still[k]
            for i in range(k + 1):
                if i in inner:
                    total = total + inner[i] * X[k - i]
            X.append(total / (k + 1))
        return X

    def _coefficients_of(self, point: BallTime, count: int) -> list[arb_mat]:
        """Return the coefficients of A's moving rows, (p, n) each."""
        found = [arb_mat(len(self._moving), self._system.n) for _ in range(count)]
        for (i, j), entry in self._system.A.entries.items():
            for k, one in enumerate(_coefficients(point, entry, count)):
                found[k][self._row[i], j] = one
        return found

    def _moving_columns(self, A: arb_mat) -> arb_mat:
        return arb_mat([[A[i, j] for j in self._moving] for i in range(len(self._moving))])

    def _still_columns(self, A: arb_mat) -> arb_mat:
        found = arb_mat(A)
        for i in range(len(self._moving)):
            for j in self._moving:
                found[i, j] = arb(0)
        return found

    def _identity(self) -> arb_mat:
        found = arb_mat(len(self._moving), self._system.n)
        for i, j in enumerate(self._moving):
            found[i, j] = arb(1)
        return found

    def _unit(self) -> arb_mat:
        n = self._system.n
        return arb_mat(n, n, [int(i == j) for i in range(n) for j in range(n)])

    def _whole(self, moving: arb_mat, *, first: bool) -> arb_mat:
        """Return all rows, given the moving ones: the others are those of I, or of 0 in later terms."""
        n = self._system.n
        found = self._unit() if first else arb_mat(n, n)
        for i, j in enumerate(self._moving):
            for k in range(n):
                found[j, k] = moving[i, k]
        return found


def ball_matrix(system: System, matrix: Matrix) -> arb_mat:
    """Return the balls of a matrix of constants; use inside ``precision``.

    Raises
    ------
    OutsideDomainError, KeyError
        as ``BallSegment.rows``
    """
    point = BallPoint(system, {}, 1)
    found = arb_mat(matrix.rows, matrix.columns)
    for (i, j), entry in matrix.entries.items():
        found[i, j] = point.value(entry)[0]
    return found


def ball_number(system: System, expression: Expression) -> arb:
    """Return the ball of a constant; otherwise as ``ball_matrix``."""
    found: arb = BallPoint(system, {}, 1).value(expression)[0]
    return found


def _coefficients(point: BallTime, entry: Expression, count: int) -> list[arb]:
    series = point.value(entry)
    return [series[k] for k in range(count)]


def _norm(A: arb_mat) -> arb:
    """Return the largest sum of a row of absolute values."""
    largest = arb(0)
    for row in A.tolist():
        total = arb(0)
        for entry in row:
            total += entry.abs_upper()
        largest = largest.max(total)
    return largest


def _rational(ball: arb) -> Fraction:
    """Return a number that the ball may contain, as a fraction."""
    middle: fmpq = ball.mid().fmpq()
    return Fraction(int(middle.p), int(middle.q))


def _exact(value: Fraction) -> arb:
    return arb(fmpq(value.numerator, value.denominator))


def _is_zero(matrix: arb_mat) -> bool:
    return all(entry.is_zero() for entry in matrix.entries())


def _total(parts: Iterable[arb_mat]) -> arb_mat:
    found = None
    for one in parts:
        found = one if found is None else found + one
    assert found is not None
    return found
