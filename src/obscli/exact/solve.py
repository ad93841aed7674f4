"""Solving a critical polynomial for one parameter, so that the system can be specialised on its zeros.

q = 0 is solved where q is linear or quadratic in a parameter that occurs nowhere else in it, or where q
is a polynomial in one half-angle tangent τ = tan(b/2) (b proportional to a parameter) or one exponential.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from obscli.exact.interpreter import polynomial_coefficients
from obscli.model.expression import (
    Apply,
    Expression,
    Number,
    Pi,
    Product,
    Symbol,
    add,
    divide,
    multiply,
    negate,
    number,
    power,
    symbols,
)


if TYPE_CHECKING:
    from flint import fmpz_mpoly as Polynomial

    from obscli.exact.interpreter import Interpreter

_HALF = Fraction(1, 2)
#: tan of multiples of π/12 that have square roots of rationals for a tangent: value squared → multiple of π.
_TANGENTS = {Fraction(1): Fraction(1, 4), Fraction(3): Fraction(1, 3), Fraction(1, 3): Fraction(1, 6)}


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """A parameter and its value on (one branch of) a hypersurface."""

    name: str
    value: Expression


def solve(it: Interpreter, polynomial: Polynomial) -> list[Solution]:
    """Return the branches of polynomial = 0, empty where it cannot be solved for a parameter."""
    degrees = polynomial.degrees()
    used = [k for k, degree in enumerate(degrees) if degree > 0]
    generators = it.field.generators
    hidden = {
        name for k in used if generators[k].kind != "parameter" for name in symbols(generators[k].meaning)
    }
    for degree in (1, 2):
        # the parameter declared last is solved for: alpha_w = alpha_omega, b = a
        for k in reversed(used):
            generator = generators[k]
            if generator.kind == "parameter" and degrees[k] == degree and generator.name not in hidden:
                return _solve_parameter(it, polynomial, k)
    if len(used) == 1:
        return _solve_alone(it, polynomial, used[0])
    return []


def _solve_parameter(it: Interpreter, polynomial: Polynomial, k: int) -> list[Solution]:
    coefficients = [it.expression(c) for c in polynomial_coefficients(polynomial, k)]
    name = it.field.generators[k].name
    return [Solution(name, value) for value in _roots(coefficients)]


def _roots(coefficients: list[Expression]) -> list[Expression]:
    if len(coefficients) == 2:
        return [negate(divide(coefficients[0], coefficients[1]))]
    c, b, a = coefficients
    root = power(add(power(b, 2), multiply(number(-4), a, c)), _HALF)
    below = multiply(number(2), a)
    return [divide(add(negate(b), sign), below) for sign in (root, negate(root))]


def _solve_alone(it: Interpreter, polynomial: Polynomial, k: int) -> list[Solution]:
    generator = it.field.generators[k]
    if generator.argument is None or generator.kind not in {"angle", "exponential"}:
        return []
    coefficients = [Fraction(int(c.leading_coefficient())) if c else Fraction(0)
                    for c in polynomial_coefficients(polynomial, k)]  # fmt: skip
    values = _rational_roots(coefficients)
    inverse = _twice_arctangent if generator.kind == "angle" else _logarithm
    angles = [angle for value in values if (angle := inverse(value)) is not None]
    return [s for angle in angles if (s := _invert(generator.argument, angle)) is not None]


def _rational_roots(coefficients: list[Fraction]) -> list[tuple[Fraction, int]]:
    """Return real roots of a polynomial of degree 1, or of x² = r, as (square, sign)."""
    if len(coefficients) == 2:
        root = -coefficients[0] / coefficients[1]
        return [(root * root, (root > 0) - (root < 0))]
    if len(coefficients) == 3 and coefficients[1] == 0:
        square = -coefficients[0] / coefficients[2]
        return [(square, 1), (square, -1)] if square > 0 else []
    return []


def _twice_arctangent(root: tuple[Fraction, int]) -> Expression | None:
    square, sign = root
    if not sign:
        return number(0)
    if square in _TANGENTS:
        return multiply(Number(2 * sign * _TANGENTS[square]), Pi())
    return multiply(number(2 * sign), Apply("atan", power(Number(square), _HALF)))


def _logarithm(root: tuple[Fraction, int]) -> Expression | None:
    square, sign = root
    if sign <= 0:
        return None
    return number(0) if square == 1 else multiply(Number(_HALF), Apply("log", Number(square)))


def _invert(argument: Expression, value: Expression) -> Solution | None:
    """Solve argument = value for the only parameter in it, where argument is a rational multiple of it."""
    factor, core = _multiple(argument)
    if isinstance(core, Symbol):
        return Solution(core.name, multiply(Number(1 / factor), value))
    return None


def _multiple(argument: Expression) -> tuple[Fraction, Expression]:
    if isinstance(argument, Product) and len(argument.factors) == 2 and isinstance(argument.factors[0], Number):
        return argument.factors[0].value, argument.factors[1]
    return Fraction(1), argument


def points_at_infinity(it: Interpreter) -> list[Solution]:
    """Return base angles b = π of constants: τ = tan(b/2) is infinite there, so no factor shows it."""
    found = []
    for k, generator in enumerate(it.field.generators):
        if generator.kind == "angle" and generator.argument is not None and not it.field.varies(k):
            solution = _invert(generator.argument, Pi())
            if solution is not None:
                found.append(solution)
    return found
