"""The error beside a value is what rounding gives it: |value − exact| ≤ 40 σ for whatever expression.

σ is the standard deviation of a sum of random roundings. A rounding itself is at most 2 σ, numpy's functions are
off by up to 16 σ, and roundings that happen to agree add to more than their squares do.
"""

from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from obscli.model.expression import Apply, Number, Pi, Power, Product, Sum, Symbol, negate
from obscli.model.reader import read_text
from obscli.numeric.program import ROUNDING, Program


NAMES = ("x", "y", "z")
MOST = 40
TINY = 1e-300

symbols = st.sampled_from([Symbol(name) for name in NAMES])
dyadic = st.fractions(-8, 8, max_denominator=1).map(lambda q: Number(q / 4))
leaves = symbols | dyadic


def bounded(node):
    """A node of size at most 1, so that no function overflows and no argument nears a singularity."""
    return Apply("sin", node)


def away(node):
    """A node between 1 and 3."""
    return Sum((Number(Fraction(2)), bounded(node)))


def grown(inner):
    entire = st.tuples(st.sampled_from(["sin", "cos", "atan", "tanh", "asinh"]), inner).map(
        lambda p: Apply(*p)
    )
    tame = st.tuples(st.sampled_from(["exp", "sinh", "cosh", "tan"]), inner).map(
        lambda p: Apply(p[0], bounded(p[1]))
    )
    halved = st.tuples(st.sampled_from(["asin", "acos", "atanh"]), inner).map(
        lambda p: Apply(p[0], Product((Number(Fraction(1, 2)), bounded(p[1]))))
    )
    outside = st.tuples(st.sampled_from(["log", "acosh"]), inner).map(
        lambda p: Apply(p[0], Sum((Number(Fraction(1, 2)), away(p[1]))))
    )
    powers = st.tuples(inner, st.sampled_from([-1, -2, Fraction(1, 2), Fraction(-3, 2), 3])).map(
        lambda p: Power(away(p[0]), Fraction(p[1]))
    )
    squares = inner.map(lambda u: Power(u, Fraction(2)))
    sums = st.lists(inner, min_size=2, max_size=4).map(lambda p: Sum(tuple(p)))
    products = st.lists(inner, min_size=2, max_size=3).map(lambda p: Product(tuple(p)))
    cancelling = st.tuples(inner, inner).map(lambda p: Sum((Sum((p[0], p[1])), negate(p[0]))))
    return st.one_of(entire, tame, halved, outside, powers, squares, sums, products, cancelling)


trees = st.recursive(leaves, grown, max_leaves=12)
numbers = st.floats(-10, 10).filter(lambda x: x == 0 or abs(x) > 1e-3)


def exactly(node, values):
    """The value in many digits; numbers are those that doubles hold."""
    memo = {}

    def of(node):
        if id(node) not in memo:
            memo[id(node)] = _exactly(node, values, of)
        return memo[id(node)]

    return of(node)


def _exactly(node, values, of):
    match node:
        case Number(value):
            return mpmath.mpf(float(value))
        case Pi():
            return mpmath.pi
        case Symbol(name):
            return mpmath.mpf(values[name])
        case Sum(terms):
            return mpmath.fsum(map(of, terms))
        case Product(factors):
            return mpmath.fprod(map(of, factors))
        case Power(base, p):
            return of(base) ** (mpmath.mpf(p.numerator) / p.denominator)
        case Apply(name, argument):
            return getattr(mpmath, name)(of(argument))


def share_of_error(node, values, errors=None):
    """|value − exact| over what is allowed."""
    with mpmath.workdps(50):
        found = Program([node]).run_rounded(values, errors or {})[0]
        off = float(abs(mpmath.mpf(float(found.value)) - exactly(node, values)))
    return off / (MOST * float(found.error) + TINY)


@settings(max_examples=400, deadline=None)
@given(trees, numbers, numbers, numbers)
def test_values_are_within_their_error(node, x, y, z):
    assert share_of_error(node, dict(zip(NAMES, (x, y, z), strict=True))) <= 1


@settings(max_examples=100, deadline=None)
@given(trees, numbers, numbers, numbers)
def test_the_run_with_errors_gives_the_same_values(node, x, y, z):
    values = {name: np.array([one]) for name, one in zip(NAMES, (x, y, z), strict=True)}
    program = Program([node])
    assert program.run(values)[0] == program.run_rounded(values, {})[0].value


@pytest.mark.parametrize("big", [1.0, 1e6, 1e12])
def test_what_cancels_leaves_the_error_of_its_parts(big):
    """big + x − big has few digits left; its error is that of big, no more and no less."""
    x, y = Symbol("x"), Symbol("y")
    found = Program([Sum((Sum((y, x)), negate(y)))]).run_rounded({"x": 0.1, "y": big}, {})[0]
    assert big * ROUNDING / 2 <= found.error <= 4 * (big + 1) * ROUNDING


def test_partial_sums_round_too():
    """10⁸ + 10⁻⁸ − 10⁸ is 1.49e-8 in doubles: the error is that of the sum on the way."""
    node = Sum(tuple(Symbol(name) for name in NAMES))
    assert share_of_error(node, {"x": 1e8, "y": 1e-8, "z": -1e8}) <= 1


def test_numbers_that_are_no_doubles_are_rounded():
    """x − 1/3 at a double near 1/3 is wrong by the rounding of 1/3."""
    node = Sum((Number(Fraction(-1, 3)), Symbol("x")))
    x = float(Fraction(1, 3)) + 1e-12
    found = Program([node]).run_rounded({"x": x}, {})[0]
    off = abs(Fraction(float(found.value)) - (Fraction(x) - Fraction(1, 3)))
    assert float(off) <= MOST * found.error


def test_errors_of_values_are_passed_on_by_the_derivative():
    x = Symbol("x")
    for name, u in (
        ("sin", 0.3), ("cos", 0.3), ("tan", 0.3), ("asin", 0.3), ("acos", 0.3), ("atan", 0.3), ("exp", 2.0),
        ("log", 3.0), ("sinh", 1.0), ("cosh", 1.0), ("tanh", 0.4), ("asinh", 2.0), ("acosh", 2.0), ("atanh", 0.4),
    ):  # fmt: skip
        found = Program([Apply(name, x)]).run_rounded({"x": u}, {"x": 1e-6})[0]
        slope = abs(mpmath.diff(getattr(mpmath, name), u))
        assert found.error == pytest.approx(float(slope) * 1e-6, rel=1e-6), name


def test_a_square_of_what_cancels_is_no_division_by_zero():
    system = read_text(
        "parameters: {a: 2, b: 2}\nstates: [x]\nA: [[0]]\nH: [['1 + (a - b)^2']]\n", "test.yaml"
    ).systems[0]
    entry = system.H.entries[0, 0]
    found = Program([entry]).run_rounded({"a": 2.0, "b": 2.0}, {})[0]
    assert found.value == 1
    assert found.error < 1e-15


def test_the_error_of_a_square_is_known_where_its_base_is_zero():
    found = Program([Power(Symbol("t"), Fraction(2))]).run_rounded(
        {"t": np.array([0.0, 1.0])}, {"t": np.full(2, 1e-9)}
    )[0]
    np.testing.assert_allclose(found.error, [0, 2e-9], rtol=1e-6, atol=1e-300)


@pytest.mark.parametrize(("name", "u"), [("log", 0.0), ("atanh", 1.0)])
def test_a_pole_at_what_cancels_does_not_raise(name, u):
    x, y = Symbol("x"), Symbol("y")
    found = Program([Apply(name, Sum((x, negate(y))))]).run_rounded({"x": u + 2.0, "y": 2.0}, {})[0]
    assert np.isinf(found.value)
