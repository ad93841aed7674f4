"""The sign of a constant, by ball arithmetic: −√2 is as negative as −1."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from types import MappingProxyType
from typing import TYPE_CHECKING

from obscli.model.expression import (
    Apply,
    Derivative,
    Expression,
    Number,
    Pi,
    Power,
    Product,
    Sum,
    Symbol,
    postorder,
)


if TYPE_CHECKING:
    from flint import arb

    from obscli.model.system import System


def sign(value: Expression, names: Mapping[str, Expression] = MappingProxyType({})) -> int | None:
    """Return −1, 0 or 1, of a constant.

    Parameters
    ----------
    value : the constant
    names : values of symbols

    Returns
    -------
    int or None
        None where a symbol has no value, no real number comes out, or it may be zero for all that is known
    """
    if isinstance(value, Number):
        return (value.value > 0) - (value.value < 0)
    ball = _ball(value, names)
    if ball is None or not ball.is_finite() or ball.contains(0):
        return None
    return 1 if ball > 0 else -1


def sign_at_nominal(value: Expression, system: System) -> int | None:
    """Return the sign of a constant at the values that the file gives parameters; None as ``sign``."""
    return sign(value, {one.name: one.nominal for one in system.parameters if one.nominal is not None})


def _ball(value: Expression, names: Mapping[str, Expression]) -> arb | None:
    """Return a ball that contains the value, None where a symbol has no value."""
    from flint import arb  # noqa: PLC0415 - a tenth of a second, for constants that are no plain numbers only

    found: dict[int, arb] = {}
    for node in postorder(value):
        match node:
            case Number(exact):
                ball = _exact(exact)
            case Pi():
                ball = arb.pi()
            case Symbol(name):
                inner = _ball(names[name], {}) if name in names else None
                if inner is None:
                    return None
                ball = inner
            case Derivative():
                return None
            case Sum(terms):
                ball = sum((found[id(term)] for term in terms), arb(0))
            case Product(factors):
                ball = arb(1)
                for factor in factors:
                    ball *= found[id(factor)]
            case Power(base, exponent):
                ball = found[id(base)] ** _exact(exponent)
            case Apply(function, argument):
                ball = getattr(found[id(argument)], function)()
        found[id(node)] = ball
    return found[id(value)]


def _exact(value: Fraction) -> arb:
    from flint import arb, fmpq  # noqa: PLC0415 - see above

    return arb(fmpq(value.numerator, value.denominator))
