"""The analytic form of a coefficient guessed from its values in time (the papers' "try to guess").

The curve is fitted by as few functions of the dictionary as possible, on two thirds of the instants; it has
to agree within its error on the third held back as well. Amplitudes are then looked up among the monomials of
the parameters (and sums of two). A form is *not identified* where nothing fits, or where another form as
simple fits too; an amplitude stays a number where a look-up could succeed by chance.

References
----------
V. M. Morozov, F. Yu. Baklanov (2018), numerical method, step 3.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from typing import Final

import numpy as np

from obscli.model.expression import Expression, add, multiply, negate, number
from obscli.numeric.dictionary import Monomial, functions_of_time, independent, monomials
from obscli.numeric.echelon import EchelonCurves
from obscli.numeric.finding import CoefficientCurve, EchelonFinding, Guess
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import Array, Flags, Program


_MOST_TERMS: Final = 3
_HELD_BACK: Final = 3
_FEWEST: Final = 9

#: A fit agrees where it is within so many errors, and the errors are at least this fraction of the curve.
_WITHIN: Final = 2.0
_DIGITS: Final = 1e-12

#: A curve known worse than this says nothing about its form; a look-up may succeed by chance so often.
_TOO_COARSE: Final = 1e-4
_CHANCE: Final = 1e-3
_SCREENED: Final = 6


@dataclass(frozen=True, slots=True, eq=False)
class _Fit:
    columns: tuple[int, ...]
    amplitudes: Array
    spread: Array
    residual: float
    held_back: float


class Identifier:
    """Guesses the forms of the coefficients of one system.

    Parameters
    ----------
    system : the system in floating point, whose functions and parameters make the dictionary
    instants : of the curves, shape (k,)
    """

    def __init__(self, system: NumericSystem, instants: Array) -> None:
        functions = functions_of_time(system.system)
        values = Program(functions).run(system.values(instants, {}))
        self._functions, self._values = independent(functions, values, len(instants))
        self._monomials = monomials(system.system, system.constants)
        order = np.argsort([abs(one.value) for one in self._monomials], kind="stable")
        self._sorted = [self._monomials[k] for k in order]
        self._logs = np.log([abs(one.value) for one in self._sorted])
        self._held = np.arange(len(instants)) % _HELD_BACK == _HELD_BACK - 1

    def guess(self, curve: Array, error: Array) -> Guess:
        """Return the form of one coefficient.

        Parameters
        ----------
        curve, error : its values at the instants and what they may be wrong by, shape (k,)
        """
        size = float(np.abs(curve).max())
        error = np.maximum(error, _DIGITS * size)
        known = error < _TOO_COARSE * size
        if known.sum() < _FEWEST:
            return Guess(None, reason="known too coarsely, or at too few instants")
        for count in range(1, _MOST_TERMS + 1):
            fits = self._fits(curve, error, known, count)
            if len(fits) > 1:
                return Guess(None, reason=f"several forms of {count} terms fit alike")
            if fits:
                return self._named(fits[0], size)
        return Guess(None, reason="no form of the dictionary fits")

    def _fits(self, curve: Array, error: Array, known: Flags, count: int) -> list[_Fit]:
        """Return the fits with so many functions that agree everywhere, also where held back."""
        train = known & ~self._held
        found = []
        for columns in self._screened(
            curve[train] / error[train], self._values[train] / error[train, None], count
        ):
            basis = self._values[:, columns]
            weighted = basis[train] / error[train, None]
            amplitudes, *_ = np.linalg.lstsq(weighted, curve[train] / error[train], rcond=None)
            off = np.abs(curve - basis @ amplitudes)
            share = np.abs(basis * amplitudes).max(axis=0)
            if (off[known] <= _WITHIN * error[known]).all() and (share > error[known].min()).all():
                spread = np.linalg.norm(np.linalg.pinv(weighted), axis=1) * np.sqrt(count)
                size = np.abs(curve).max()
                held = known & self._held
                found.append(
                    _Fit(
                        columns,
                        amplitudes,
                        spread,
                        float(off[train].max() / size),
                        float(off[held].max() / size),
                    )
                )
        return found

    def _screened(self, y: Array, basis: Array, count: int) -> list[tuple[int, ...]]:
        """Return the few sets of columns that fit best, by their normal equations."""
        scale = np.linalg.norm(basis, axis=0)
        scale[scale == 0] = 1
        unit = basis / scale
        gram, moment = unit.T @ unit, unit.T @ y
        sets = np.array(list(combinations(range(basis.shape[1]), count)))
        if not len(sets):
            return []
        matrices = gram[sets[:, :, None], sets[:, None, :]] + 1e-13 * np.eye(count)
        explained = np.einsum(
            "ka,ka->k", moment[sets], np.linalg.solve(matrices, moment[sets][..., None])[..., 0]
        )
        best = np.argsort(-explained, kind="stable")[:_SCREENED]
        return [tuple(int(c) for c in sets[k]) for k in best]

    def _named(self, fit: _Fit, size: float) -> Guess:
        terms, in_digits = [], False
        for column, amplitude, spread in zip(fit.columns, fit.amplitudes, fit.spread, strict=True):
            tolerance = max(2 * float(spread), _DIGITS * size / float(np.abs(self._values[:, column]).max()))
            named = self._amplitude(float(amplitude), tolerance)
            in_digits |= named is None
            size_known = _digits(float(amplitude), tolerance) if named is None else named
            terms.append(multiply(size_known, self._functions[column]))
        return Guess(add(*terms), fit.residual, fit.held_back, in_digits=in_digits)

    def _amplitude(self, a: float, tolerance: float) -> Expression | None:
        """Return a as a monomial of the parameters or a sum of two, where just one simple one is close."""
        found = self._monomial(a, tolerance)
        return self._sum(a, tolerance) if found is None else found

    def _monomial(self, a: float, tolerance: float) -> Expression | None:
        near = self._near(a, tolerance)
        if not near:
            return None
        simplest = min(near, key=lambda one: one.degree)
        rivals = sum(one.degree <= simplest.degree for one in self._monomials)
        if rivals * tolerance / abs(a) > _CHANCE or sum(one.degree == simplest.degree for one in near) > 1:
            return None
        return _signed(simplest, a)

    def _sum(self, a: float, tolerance: float) -> Expression | None:
        simple = [one for one in self._monomials if one.degree <= 2 and abs(one.value) > 10 * tolerance]
        hits = []
        for first in simple:
            for sign in (1, -1):
                rest = a - sign * first.value
                if abs(rest) > 10 * tolerance:
                    hits += [
                        (sign, first, other, rest)
                        for other in self._near(rest, tolerance)
                        if other.degree <= 2
                    ]
        pairs = {frozenset((id(first), id(other))) for _, first, other, _ in hits}
        if len(pairs) != 1 or len(simple) ** 2 * tolerance / min(abs(hits[0][3]), abs(a)) > _CHANCE:
            return None
        sign, first, other, rest = hits[0]
        one = first.expression if sign > 0 else negate(first.expression)
        return add(one, _signed(other, rest))

    def _near(self, a: float, tolerance: float) -> list[Monomial]:
        relative = tolerance / abs(a)
        if relative > 1e-3:
            return []
        low, high = np.searchsorted(self._logs, np.log(abs(a)) + np.array([-relative, relative]) * (1 + 1e-9))
        return self._sorted[low:high]


def identified(curves: EchelonCurves, system: NumericSystem) -> EchelonFinding:
    """Return the basis with a guess for every coefficient that is not zero."""
    identifier = Identifier(system, curves.instants)
    found = []
    for p, f in zip(*np.nonzero(curves.present), strict=True):
        values, errors = curves.coefficients[:, p, f], curves.errors[:, p, f]
        guess = identifier.guess(values, errors)
        found.append(
            CoefficientCurve(
                pivot=curves.names[curves.pivots[p]],
                free=curves.names[curves.free[f]],
                instants=tuple(curves.instants.tolist()),
                values=tuple(values.tolist()),
                errors=tuple(errors.tolist()),
                guess=guess,
                fitted=_fitted(guess, system, curves.instants),
                standing="not identified" if guess.expression is None else "guess",
            )
        )
    return EchelonFinding(tuple(curves.names[p] for p in curves.pivots), tuple(found))


def _fitted(guess: Guess, system: NumericSystem, instants: Array) -> tuple[float, ...] | None:
    if guess.expression is None:
        return None
    value = Program([guess.expression]).run(system.values(instants, {}))[0]
    return tuple(np.broadcast_to(value, instants.shape).tolist())


def _signed(one: Monomial, a: float) -> Expression:
    return one.expression if one.value * a > 0 else negate(one.expression)


def _digits(a: float, tolerance: float) -> Expression:
    """Return the number with the digits that are known, at most ten."""
    known = min(max(int(-np.log10(max(tolerance / abs(a), 1e-10))), 3), 10)
    return number(Fraction(f"{a:.{known}g}"))
