"""Every expression has the value that exact arithmetic gives it, to a few units in the last place."""

import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from obscli.model.expression import ELEMENTARY, Apply, Derivative, Number, Pi, Power, Product, Sum, Symbol
from obscli.numeric.program import FUNCTIONS, Program, constant_value, jet


X = Symbol("x")

#: Domains, and how many units in the last place numpy's functions may be off (SIMD versions: 4).
DOMAINS = {
    "sin": (-50, 50), "cos": (-50, 50), "tan": (-1.5, 1.5), "asin": (-1, 1), "acos": (-1, 1),
    "atan": (-1e3, 1e3), "exp": (-700, 700), "log": (1e-300, 1e300), "sinh": (-700, 700), "cosh": (-700, 700),
    "tanh": (-30, 30), "asinh": (-1e9, 1e9), "acosh": (1, 1e9), "atanh": (-0.999999, 0.999999),
}  # fmt: skip
ULPS = 4
EPS = np.finfo(float).eps


def value(expression, **values):
    return Program([expression]).run(values)[0]


def off(found, exact):
    """How many units in the last place a double is off."""
    return float(abs(mpmath.mpf(float(found)) - exact) / abs(exact) / EPS) if exact else abs(found) * 1e300


def exactly(function, u):
    return getattr(mpmath, function if function != "log" else "ln")(mpmath.mpf(u))


def test_every_elementary_function_is_covered():
    assert set(DOMAINS) == set(ELEMENTARY) == set(FUNCTIONS)


@pytest.mark.parametrize("name", DOMAINS)
def test_functions_at_random_arguments(name):
    low, high = DOMAINS[name]
    share = np.random.default_rng(len(name)).uniform(0, 1, 300)
    share[:100] **= 12  # gather some at the lower end,
    share[100:200] = 1 - share[100:200] ** 12  # and at the upper
    u = low + (high - low) * share
    found = value(Apply(name, X), x=u)
    with mpmath.workdps(50):
        worst = max(off(f, exactly(name, one)) for f, one in zip(found, u, strict=True))
    assert worst <= ULPS


@pytest.mark.parametrize(
    "p", [2, 3, -1, -2, 7, Fraction(1, 2), Fraction(-1, 2), Fraction(3, 2), Fraction(1, 3), Fraction(-5, 7)]
)
def test_powers(p):
    u = 10 ** np.random.default_rng(1).uniform(-3, 3, 100)
    found = value(Power(X, Fraction(p)), x=u)
    with mpmath.workdps(50):
        exact = [
            mpmath.mpf(one) ** (mpmath.mpf(Fraction(p).numerator) / Fraction(p).denominator) for one in u
        ]
        worst = max(off(f, e) for f, e in zip(found, exact, strict=True))
    # an exponent that is no double is off by eps/2, which the logarithm of the base multiplies
    assert worst <= ULPS + 3 * math.log(10) * abs(p) / 2


def test_powers_of_negative_bases_are_real_where_the_exponent_is_whole():
    assert value(Power(X, Fraction(3)), x=-2.0) == -8
    assert value(Power(X, Fraction(-2)), x=-2.0) == 0.25


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        (Apply("cos", Product((Number(Fraction(1, 2)), Pi()))), 0),
        (Apply("sin", Pi()), 0),
        (Apply("sin", Product((Number(Fraction(1, 6)), Pi()))), 0.5),
        (Apply("tan", Pi()), 0),
        (Apply("log", Number(Fraction(1))), 0),
        (Apply("exp", Number(Fraction(0))), 1),
        (Number(Fraction(1, 3)), 1 / 3),
        (Number(Fraction(10) ** 400), math.inf),
        (Pi(), math.pi),
    ],
)
def test_exact_values_stay_exact(expression, expected):
    assert constant_value(expression, {}) == expected


@pytest.mark.parametrize(
    ("expression", "x"),
    [
        (Apply("log", X), -1.0),
        (Apply("asin", X), 1.5),
        (Apply("acos", X), -2.0),
        (Apply("acosh", X), 0.5),
        (Apply("atanh", X), 2.0),
        (Power(X, Fraction(1, 2)), -1.0),
        (Power(X, Fraction(1, 3)), -8.0),
        (Sum((Power(X, Fraction(-1)), Product((Number(Fraction(-1)), Power(X, Fraction(-1)))))), 0.0),
    ],
)
def test_outside_its_domain_a_value_is_not_a_number(expression, x):
    for given_as in (x, np.array([x, 1.0])):
        assert np.isnan(np.atleast_1d(value(expression, x=np.float64(given_as)))[0])
        rounded = Program([expression]).run_rounded({"x": np.float64(given_as)}, {})[0]
        assert np.isnan(np.atleast_1d(rounded.value)[0])


@pytest.mark.parametrize("u", [Number(Fraction(2)), Number(Fraction(-3))])
@pytest.mark.parametrize("name", ["log", "asin", "acos", "acosh", "atanh"])
def test_constants_outside_the_domain_do_not_raise(name, u):
    with mpmath.workdps(20):
        inside = isinstance(exactly(name, float(u.value)), mpmath.mpf)
    assert math.isnan(constant_value(Apply(name, u), {})) != inside


def test_a_pole_is_infinite():
    assert np.isinf(value(Power(X, Fraction(-1)), x=np.array([0.0]))).all()


def test_functions_and_their_derivatives_are_looked_up_by_name():
    values = {"f": 2.0, jet("f", 1): 3.0, jet("f", 2): 5.0}
    roots = [Symbol("f"), Derivative("f", 1), Derivative("f", 2)]
    assert Program(roots).run(values) == [2, 3, 5]


def test_a_shared_node_is_evaluated_once():
    """2^200 additions if it were not."""
    node = X
    for _ in range(200):
        node = Sum((node, node))
    program = Program([node, X])
    assert program.run({"x": 1.0}) == [2.0**200, 1.0]
    assert program.run_rounded({"x": 1.0}, {})[0].value == 2.0**200


@settings(max_examples=50, deadline=None)
@given(st.lists(st.floats(-5, 5), min_size=1, max_size=7))
def test_a_batch_gives_what_its_instants_give_one_by_one(x):
    roots = [Sum((X, Power(X, Fraction(3)))), Product((X, X, Number(Fraction(1, 7)))), Number(Fraction(2, 3))]
    together = Program(roots).run_rounded({"x": np.array(x)}, {"x": np.full(len(x), 1e-9)})
    for k, one in enumerate(x):
        alone = Program(roots).run_rounded({"x": np.array([one])}, {"x": np.array([1e-9])})
        for a, b in zip(together, alone, strict=True):
            for part in ("value", "error"):
                many = np.broadcast_to(getattr(a, part), len(x))[k]
                np.testing.assert_allclose(many, np.broadcast_to(getattr(b, part), 1)[0], rtol=4 * EPS)
