"""Relations among functions (``invariant``) in a form that can be solved for one of the functions."""

from __future__ import annotations

from fractions import Fraction

from obscli.model.expression import Expression, Power, Sum, add, divide, multiply, negate, number, power


def largest_root(coefficients: list[Expression]) -> Expression:
    """Solve c_0 + c_1 f (+ c_2 f²) = 0 for f: the root with + before the square root."""
    if len(coefficients) == 2:
        return negate(divide(coefficients[0], coefficients[1]))
    c, b, a = coefficients
    root = power(add(power(b, 2), multiply(number(-4), a, c)), Fraction(1, 2))
    return divide(add(negate(b), root), multiply(number(2), a))


def without_square_root(relation: Expression) -> Expression:
    """Turn √u + rest = 0 into u - rest² = 0, the form in which an invariant ``norm(f) - g`` is algebraic."""
    terms = relation.terms if isinstance(relation, Sum) else (relation,)
    roots = [t for t in terms if isinstance(t, Power) and t.exponent == Fraction(1, 2)]
    if len(roots) != 1:
        return relation
    rest = add(*(t for t in terms if t is not roots[0]))
    return add(roots[0].base, negate(power(rest, 2)))
