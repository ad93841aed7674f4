"""The initial standard deviations in ``noise``: the roots of the diagonal of ``P0``."""

from __future__ import annotations

from fractions import Fraction
from math import isqrt

from obscli.model.expression import Expression, Number, Pi, Power, Product, Sum, power
from obscli.model.system import Noise, State


def prior_deviations(noise: Noise | None, states: tuple[State, ...]) -> dict[str, Expression]:
    """Return the initial standard deviation by state, for the states it is given for."""
    if noise is None or noise.P0 is None:
        return {}
    diagonal = {i: entry for (i, j), entry in noise.P0.entries.items() if i == j}
    return {states[i].name: _root(entry) for i, entry in diagonal.items()}


def _root(variance: Expression) -> Expression:
    """Return the root, taken where it is exact: of a square, or of the ratio of two squares."""
    if isinstance(variance, Power) and variance.exponent == 2 and _is_positive(variance.base):
        return variance.base
    if isinstance(variance, Number) and variance.value > 0:
        root = Fraction(isqrt(variance.value.numerator), isqrt(variance.value.denominator))
        if root**2 == variance.value:
            return Number(root)
    return power(variance, Fraction(1, 2))


def _is_positive(node: Expression) -> bool:
    """Whether the value is positive as written."""
    match node:
        case Number(value):
            return value > 0
        case Pi():
            return True
        case Product(parts) | Sum(parts):
            return all(_is_positive(part) for part in parts)
        case Power(base):
            return _is_positive(base)
    return False
