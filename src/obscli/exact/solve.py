"""Solving a critical polynomial for one parameter, so that the system can be specialised on its zeros.

q = 0 is solved where q is linear or quadratic in a parameter that occurs nowhere else in it; where q is
linear in a half-angle tangent τ = tan(b/2), b = 2 atan(…); and where q is a polynomial of degree at most
two in one cosine, one sine or one exponential. b and exponents are then solved for a parameter.
"""

from __future__ import annotations

import random
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from flint import arb, fmpq, fmpz_poly

from obscli.exact.polynomial import factored, polynomial_coefficients, prime_powers
from obscli.exact.restore import Restorer
from obscli.exact.roots import evident_sign
from obscli.model.expression import (
    Apply,
    Expression,
    Number,
    Pi,
    Power,
    Product,
    Sum,
    Symbol,
    add,
    divide,
    multiply,
    negate,
    number,
    power,
    symbols,
)
from obscli.model.notation import to_text


if TYPE_CHECKING:
    from obscli.exact.interpreter import Interpreter
    from obscli.exact.polynomial import Polynomial

_HALF = Fraction(1, 2)
_SAMPLES = 200
#: tan of multiples of π/12 that have square roots of rationals for a tangent: value squared → multiple of π.
_TANGENTS = {Fraction(1): Fraction(1, 4), Fraction(3): Fraction(1, 3), Fraction(1, 3): Fraction(1, 6)}


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """A parameter and its value on (one branch of) a hypersurface."""

    name: str
    value: Expression

    @property
    def equation(self) -> Expression:
        """An expression that vanishes where the parameter has the value."""
        return add(Symbol(self.name), negate(self.value))

    @property
    def condition(self) -> str:
        """The condition as text: ``name = value``."""
        return f"{self.name} = {to_text(self.value)}"


def solve(it: Interpreter, polynomial: Polynomial) -> list[Solution]:
    """Return the branches of polynomial = 0, empty where it cannot be solved for a parameter."""
    return [s for s in _branches(it, polynomial) if s.name not in symbols(s.value)]


def _branches(it: Interpreter, polynomial: Polynomial) -> list[Solution]:
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
    for method in (_solve_tangent, _solve_primitive, _solve_power):
        solutions = method(it, polynomial, used)
        if solutions:
            return solutions
    return _solve_alone(it, polynomial, used[0]) if len(used) == 1 else []


def _solve_parameter(it: Interpreter, polynomial: Polynomial, k: int) -> list[Solution]:
    """Solve for a parameter of degree one or two: -c/b, or (-b ± √(b² - 4ac))/2a."""
    coefficients = polynomial_coefficients(polynomial, k)
    name = it.field.generators[k].name
    if len(coefficients) == 2:
        low, high = coefficients
        if high.leading_coefficient() < 0:
            low, high = -low, -high
        above, below = Restorer(it).row_unscaled([-low, high])
        return [Solution(name, divide(above, below))]
    c, b, a = coefficients
    outside, inside = _square_part(b * b - 4 * a * c)
    root = multiply(it.expression(outside), power(it.expression(inside), _HALF))
    below = multiply(number(2), it.expression(a))
    middle = negate(it.expression(b)) if b else number(0)
    return [Solution(name, divide(add(middle, sign), below)) for sign in (root, negate(root))]


def _square_part(polynomial: Polynomial) -> tuple[Polynomial, Polynomial]:
    """Write a polynomial as s² w with w free of squares; the sign of s is of no matter for ±√."""
    constant, factors = factored(polynomial)
    context = polynomial.context()
    outside, inside = context.constant(1), context.constant(-1 if constant < 0 else 1)
    numbers = [(context.constant(p), e) for p, e in prime_powers(abs(constant), wholly=False)]
    for factor, exponent in [*numbers, *factors]:
        outside = outside * factor ** (int(exponent) // 2)
        inside = inside * factor ** (int(exponent) % 2)
    return outside, inside


def _solve_power(it: Interpreter, polynomial: Polynomial, used: list[int]) -> list[Solution]:
    """p^d = r with d odd: the real root."""
    for k in reversed(used):
        generator = it.field.generators[k]
        coefficients = polynomial_coefficients(polynomial, k)
        degree = len(coefficients) - 1
        if generator.kind == "parameter" and degree % 2 and not any(coefficients[1:-1]):
            ratio = divide(negate(it.expression(coefficients[0])), it.expression(coefficients[-1]))
            return [Solution(generator.name, power(ratio, Fraction(1, degree)))]
    return []


def _solve_primitive(it: Interpreter, polynomial: Polynomial, used: list[int]) -> list[Solution]:
    """log u = r: u = exp r; asin u = r: u = sin r; atan u = r: u = tan r."""
    for k in used:
        generator = it.field.generators[k]
        inverse = {"log": "exp", "asin": "sin", "atan": "tan"}.get(generator.function)
        if inverse is None or polynomial.degrees()[k] != 1 or generator.argument is None:
            continue
        low, high = polynomial_coefficients(polynomial, k)
        root = divide(negate(it.expression(low)), it.expression(high)) if low else number(0)
        value = Apply(inverse, root) if low else number(1 if inverse == "exp" else 0)
        solution = _invert(it, generator.argument, value)
        if solution is not None:
            return [solution]
    return []


def _solve_tangent(it: Interpreter, polynomial: Polynomial, used: list[int]) -> list[Solution]:
    """τ = r, linear: the base angle is 2 atan(r), written as a multiple of π where it is one."""
    for k in reversed(used):
        generator = it.field.generators[k]
        if generator.kind != "angle" or polynomial.degrees()[k] != 1 or generator.argument is None:
            continue
        low, high = polynomial_coefficients(polynomial, k)
        root = divide(negate(it.expression(low)), it.expression(high))
        if len(used) == 1:
            ratio = Fraction(int(-low.leading_coefficient()) if low else 0, int(high.leading_coefficient()))
            value = _twice_arctangent(ratio * ratio, ratio)
        else:
            value = _related_angle(it, polynomial, k) or multiply(number(2), Apply("atan", root))
        solutions = _turns(it, generator.argument, [value])
        if solutions:
            return solutions
    return []


def _turns(it: Interpreter, argument: Expression, values: list[Expression]) -> list[Solution]:
    """Solve base angle = value modulo 2π: for an angle k p all of p = (value + 2πj)/k, j < k."""
    turns = 1
    if isinstance(argument, Product) and isinstance(argument.factors[0], Number):
        turns = argument.factors[0].value.numerator
    whole = [_turned(value, j, turns) for value in values for j in range(turns)]
    return [s for value in whole if (s := _invert(it, argument, value)) is not None]


def _turned(value: Expression, j: int, turns: int) -> Expression:
    """Return value + 2πj, where it is a multiple of π brought into (-k, k] π for k turns."""
    match value:
        case Pi():
            multiple = Fraction(1)
        case Number(v) if v == 0:
            multiple = Fraction(0)
        case Product((Number(v), Pi())):
            multiple = v
        case _:
            return add(value, multiply(number(2 * j), Pi())) if j else value
    multiple += 2 * j
    return multiply(Number(multiple - 2 * turns if multiple > turns else multiple), Pi())


def _related_angle(it: Interpreter, polynomial: Polynomial, k: int) -> Expression | None:
    """τ_k = ±τ_j: b_k = ±b_j;  τ_k τ_j = 1: b_k = π - b_j;  τ_k τ_j = -1: b_k = b_j - π."""
    for j, generator in enumerate(it.field.generators):
        if j == k or generator.kind != "angle" or generator.argument is None:
            continue
        mine, other = it.field.ctx.gen(k), it.field.ctx.gen(j)
        turned = negate(generator.argument)
        for form, value in (
            (mine - other, generator.argument),
            (mine + other, turned),
            (mine * other - 1, add(Pi(), turned)),
            (mine * other + 1, add(generator.argument, negate(Pi()))),
        ):
            if polynomial in (form, -form):
                return value
    return None


def _solve_alone(it: Interpreter, polynomial: Polynomial, k: int) -> list[Solution]:
    """Solve a polynomial in a single angle or exponential."""
    generator = it.field.generators[k]
    if generator.argument is None:
        return []
    if generator.kind == "exponential":
        roots = [r for r in _constant_roots(polynomial_coefficients(polynomial, k)) if _positive(r)]
        values: list[Expression] = [number(0) if root == number(1) else Apply("log", root) for root in roots]
    elif generator.kind == "angle":
        return _turns(it, generator.argument, _angles(it, polynomial, k))
    else:
        return []
    return [s for value in values if (s := _invert(it, generator.argument, value)) is not None]


def _angles(it: Interpreter, polynomial: Polynomial, k: int) -> list[Expression]:
    """Solve for the base angle: τ² = r, or a polynomial of degree two in its cosine or its sine."""
    coefficients = polynomial_coefficients(polynomial, k)
    if len(coefficients) == 3 and not coefficients[1]:
        square = Fraction(
            -int(coefficients[0].leading_coefficient()), int(coefficients[2].leading_coefficient())
        )
        return [_twice_arctangent(square, sign) for sign in (1, -1)] if square > 0 else []
    by_function = Restorer(it).in_one_function(polynomial, k)
    if by_function is None:
        return [multiply(number(2), Apply("atan", root)) for root in _constant_roots(coefficients)]
    function, parts = by_function
    roots = [root for root in _constant_roots(parts) if _at_most_one(root)]
    if function == "cos":
        return [multiply(number(sign), Apply("acos", root)) for root in roots for sign in (1, -1)]
    return [
        angle for root in roots for angle in (Apply("asin", root), add(Pi(), negate(Apply("asin", root))))
    ]


def _constant_roots(coefficients: list[Polynomial]) -> list[Expression]:
    """Return the real roots of a polynomial with integer coefficients of degree one or two."""
    numbers = [Fraction(int(c.leading_coefficient())) if c else Fraction(0) for c in coefficients]
    if len(numbers) == 2:
        return [Number(-numbers[0] / numbers[1])]
    if len(numbers) != 3:
        return []
    c, b, a = numbers
    discriminant = b * b - 4 * a * c
    if discriminant < 0:
        return []
    root = power(Number(discriminant), _HALF)
    return [divide(add(Number(-b), multiply(number(sign), root)), Number(2 * a)) for sign in (1, -1)]


def _positive(root: Expression) -> bool:
    return _ball(root) > 0


def _at_most_one(root: Expression) -> bool:
    return abs(_ball(root)) <= 1 or (isinstance(root, Number) and abs(root.value) <= 1)


def _ball(root: Expression) -> arb:
    """Return the ball of a number made of rationals and square roots."""
    match root:
        case Number(value):
            return arb(fmpq(value.numerator, value.denominator))
        case Sum(terms):
            return sum((_ball(term) for term in terms), arb(0))
        case Product(factors):
            result = arb(1)
            for factor in factors:
                result = result * _ball(factor)
            return result
        case Power(base, exponent):
            return _ball(base) ** arb(fmpq(exponent.numerator, exponent.denominator))
    raise TypeError(root)


def _twice_arctangent(square: Fraction, sign: Fraction | int) -> Expression:
    """Return 2 atan(±√square)."""
    if not square:
        return number(0)
    direction = 1 if sign > 0 else -1
    if square in _TANGENTS:
        return multiply(Number(2 * direction * _TANGENTS[square]), Pi())
    return multiply(number(2 * direction), Apply("atan", power(Number(square), _HALF)))


def _invert(it: Interpreter, argument: Expression, value: Expression) -> Solution | None:
    """Solve argument = value for a parameter in which the argument is linear and that value is free of."""
    element = it.read(argument)
    for k in reversed(range(len(it.field.generators))):
        generator = it.field.generators[k]
        if generator.kind != "parameter" or element.num.degrees()[k] != 1 or element.den.degrees()[k] > 0:
            continue
        low, high = polynomial_coefficients(element.num, k)
        mixed = any(
            generator.name in symbols(it.field.generators[j].meaning)
            for j, d in enumerate(high.degrees())
            if d > 0
        )
        if mixed or generator.name in symbols(value):
            continue
        whole = multiply(value, it.expression(element.den)) if not element.den.is_one() else value
        above = add(whole, negate(it.expression(low))) if low else whole
        return Solution(generator.name, divide(above, it.expression(high)) if not high.is_one() else above)
    return None


def takes_both_signs(it: Interpreter, polynomial: Polynomial) -> bool:
    """Whether a polynomial in constants is seen to change sign: then its zeros are a real hypersurface.

    (An irreducible polynomial has zeros of real codimension one exactly if it changes sign.) Values of
    parameters and half-angle tangents are free reals, of exponentials and roots positive ones. One that is
    linear in a parameter does.
    """
    if any(
        degree == 1 and it.field.generators[k].kind == "parameter"
        for k, degree in enumerate(polynomial.degrees())
    ):
        return True
    source = random.Random(1)  # noqa: S311  (points to try, no secret)
    positive = [g.kind == "exponential" or (g.kind == "root" and g.positive) for g in it.field.generators]
    signs = set()
    for attempt in range(_SAMPLES):
        spread = 10 ** (attempt % 4)
        values = [
            Fraction(abs(v) or 1, source.randint(1, 9 * spread)) if positive[k] else Fraction(v)
            for k, v in enumerate(source.randint(-9 * spread, 9 * spread) for _ in it.field.generators)
        ]
        value = _value(polynomial, values)
        if value:
            signs.add(value > 0)
        if len(signs) == 2:
            return True
    return False


def _value(polynomial: Polynomial, values: list[Fraction]) -> Fraction:
    total = Fraction(0)
    for exponents, coefficient in polynomial.terms():
        term = Fraction(int(coefficient))
        for k, e in enumerate(exponents):
            if e:
                term *= values[k] ** int(e)
        total += term
    return total


def proved_definite(it: Interpreter, polynomial: Polynomial) -> bool:
    """Whether a polynomial is proved to have no zeros of codimension one.

    Quadratic in one generator with a discriminant of evident negative sign, or without real roots at all.
    """
    used = [k for k, degree in enumerate(polynomial.degrees()) if degree > 0]
    for k in used:
        if polynomial.degrees()[k] == 2:
            sign = evident_sign(it, polynomial.discriminant(k), assumed=False)
            if sign is not None and sign < 0:
                return True
    if len(used) != 1:
        return False
    coefficients = [
        int(c.leading_coefficient()) if c else 0 for c in polynomial_coefficients(polynomial, used[0])
    ]
    return not any(pair[0].imag == 0 for pair in fmpz_poly(coefficients).complex_roots())  # type: ignore[index]


def points_at_infinity(it: Interpreter) -> list[tuple[str, Solution | None]]:
    """Return base angles b = π of constants: τ = tan(b/2) is infinite there, so no factor shows it."""
    found: list[tuple[str, Solution | None]] = []
    for k, generator in enumerate(it.field.generators):
        if generator.kind == "angle" and not generator.numeric and not it.field.varies(k):
            assert generator.argument is not None
            condition = f"{to_text(generator.argument)} = pi"
            solutions: list[Solution | None] = [*_turns(it, generator.argument, [Pi()])]
            found += [(condition, solution) for solution in solutions or [None]]
    return found
