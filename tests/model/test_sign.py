"""The sign of constants: that of their value, and nothing where it is not certain."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from obscli.model.expression import (
    ELEMENTARY,
    Apply,
    Derivative,
    Number,
    Pi,
    Power,
    Symbol,
    add,
    multiply,
    negate,
    number,
)
from obscli.model.sign import sign


TERMS = st.recursive(
    st.builds(number, st.integers(-9, 9)) | st.just(Pi()),
    lambda inner: (
        st.builds(add, inner, inner)
        | st.builds(multiply, inner, inner)
        | st.builds(Apply, st.sampled_from(["sin", "cos", "atan", "tanh", "asinh"]), inner)
    ),
    max_leaves=12,
)


def value(node):
    match node:
        case Number(exact):
            return float(exact)
        case Pi():
            return math.pi
        case Apply(function, argument):
            return getattr(math, function)(value(argument))
        case _:
            parts = [value(part) for part in getattr(node, "terms", None) or node.factors]
            return math.fsum(parts) if hasattr(node, "terms") else math.prod(parts)


@given(TERMS)
def test_the_sign_is_that_of_the_value(node):
    found, expected = sign(node), value(node)
    if abs(expected) > 1e-9:
        assert found == (1 if expected > 0 else -1)
    else:
        assert found in {0, None, 1 if expected > 0 else -1}


@given(TERMS)
def test_the_sign_turns_with_the_number(node):
    found = sign(node)
    assert sign(negate(node)) == (None if found is None else -found)


@pytest.mark.parametrize("function", ELEMENTARY)
def test_all_functions_have_signs(function):
    at = number(2) if function == "acosh" else multiply(number(1), Power(number(3), -number(1).value / 2))
    expected = getattr(math, function)(2 if function == "acosh" else 3**-0.5)
    assert sign(Apply(function, at)) == (1 if expected > 0 else -1)


def test_what_is_not_known_has_no_sign():
    x = Symbol("x")
    assert sign(x) is None
    assert sign(Derivative("x", 1), {"x": number(1)}) is None
    assert sign(Apply("log", number(-1))) is None
    assert sign(Power(number(-2), number(1).value / 2)) is None
    assert sign(Apply("sin", Pi())) is None
    assert sign(add(x, number(-3)), {"x": number(2)}) == -1
