"""Relations among functions (``invariant``) in a form that can be solved for one of the functions."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

from obscli.exact.errors import UndecidedError
from obscli.model.expression import (
    Apply,
    Expression,
    Power,
    Sum,
    add,
    children,
    divide,
    multiply,
    negate,
    number,
    postorder,
    power,
)
from obscli.model.notation import to_text


if TYPE_CHECKING:
    from obscli.exact.reader import Reader


def require_one_branch(it: Reader, expressions: Sequence[Expression], roots: Sequence[str]) -> None:
    """Refuse a model that contains by itself the root by which an invariant gives a function.

    f² = 2 leaves open whether f is √2 or -√2, which is of no matter unless √2 stands in the model as well.

    Raises
    ------
    UndecidedError : an expression brings in one of the ``roots`` otherwise than through the function
    """
    indices = [it.field.index[name] for name in roots]
    for node in postorder(*expressions) if indices else ():
        brings = isinstance(node, Apply | Power) and _has(it, node, indices)
        if brings and not any(_has(it, part, indices) for part in children(node)):
            raise UndecidedError(
                f"an invariant leaves the sign of {to_text(node)} open; state it for one sign, "
                "for example f - sqrt(2) instead of f**2 - 2"
            )


def _has(it: Reader, node: Expression, indices: Sequence[int]) -> bool:
    element = it.read(node)
    return any(max(element.num.degrees()[k], element.den.degrees()[k]) > 0 for k in indices)


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
