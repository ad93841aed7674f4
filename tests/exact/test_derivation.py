"""The field is a faithful picture of the functions: its derivation and its values are theirs.

Random expressions over the grammar. derive(read(e)) = read(e') says that the generators' rules are right;
that e and the expression printed for read(e) agree in ball arithmetic says that the generators mean what
they are said to mean.
"""

from fractions import Fraction

import pytest
from hypothesis import HealthCheck, assume, given, reject, settings
from hypothesis import strategies as st

from obscli.exact.ball import BallPoint, OutsideDomainError, precision
from obscli.exact.errors import JetOverflowError, UndecidedError, UndefinedError
from obscli.exact.interpreter import Interpreter
from obscli.model.expression import (
    Apply,
    Derivative,
    Number,
    Pi,
    Power,
    Symbol,
    TimeDerivative,
    add,
    multiply,
    negate,
    power,
)
from obscli.model.notation import to_text
from obscli.model.reader import read_text


SYSTEM = read_text(
    "parameters: {a: {assume: positive}, c: null}\nfunctions:\n  f: {}\n  q: {derivative: c*q - t}\n"
    "states: [x]\nA: [[0]]\nH: [[1]]\n",
    "derivation.yaml",
).systems[0]
DERIVE = TimeDerivative("t", {"q": SYSTEM.functions[1].derivative}, frozenset({"f"}))
HALF = Fraction(1, 2)

NUMBERS = st.fractions(min_value=-3, max_value=3, max_denominator=4).map(Number)
LEAVES = st.one_of(
    NUMBERS,
    st.sampled_from(
        [
            Symbol("t"),
            Symbol("t"),
            Symbol("a"),
            Symbol("c"),
            Symbol("f"),
            Symbol("q"),
            Derivative("f", 1),
            Pi(),
        ]
    ),
)
# arguments in which angles and exponents are linear, as they are in models: w*t + phi, a*t^2, f + c
PHASES = st.lists(
    st.tuples(
        st.fractions(min_value=-2, max_value=2, max_denominator=3).filter(bool).map(Number),
        st.sampled_from([(), ("a",), ("c",)]),
        st.sampled_from([("t",), ("t", "t"), ("f",), ("c",), ("q",)]),
    ),
    min_size=1,
    max_size=2,
).map(lambda parts: add(*(multiply(k, *(Symbol(s) for s in (*p, *v))) for k, p, v in parts)))


def _one_plus_square(u):
    return add(Number(Fraction(1)), power(u, 2))


def _nodes(inner):
    """Nodes whose functions are of phases or of squares: roots and logarithms exist everywhere."""
    polynomial = st.sampled_from([Symbol("t"), Symbol("a"), Symbol("c"), multiply(Symbol("a"), Symbol("t"))])
    return st.one_of(
        st.lists(inner, min_size=2, max_size=3).map(lambda xs: add(*xs)),
        st.lists(inner, min_size=2, max_size=3).map(lambda xs: multiply(*xs)),
        st.tuples(inner, st.sampled_from([-1, 2, -2])).map(lambda x: power(*x)),
        st.tuples(st.sampled_from(["sin", "cos", "tan", "exp", "sinh", "cosh", "tanh"]), PHASES).map(
            lambda x: Apply(*x)
        ),
        st.tuples(st.sampled_from(["atan", "asinh", "asin", "acos", "atanh"]), polynomial).map(
            lambda x: Apply(*x)
        ),
        polynomial.map(lambda u: Apply("log", _one_plus_square(u))),
        st.tuples(
            polynomial, st.sampled_from([HALF, -HALF, Fraction(3, 2), Fraction(1, 3), Fraction(2, 3)])
        ).map(lambda x: Power(_one_plus_square(x[0]), x[1])),
    )


def _nested(inner):
    """Any function of anything: what an arbitrary file may hold."""
    return st.one_of(
        st.lists(inner, min_size=2, max_size=2).map(lambda xs: add(*xs)),
        st.lists(inner, min_size=2, max_size=2).map(lambda xs: multiply(*xs)),
        st.tuples(st.sampled_from(["sin", "cos", "exp", "tanh", "atan", "asinh"]), inner).map(
            lambda x: Apply(*x)
        ),
        inner.map(lambda u: Apply("log", _one_plus_square(u))),
        inner.map(lambda u: Power(_one_plus_square(u), HALF)),
    )


PLAIN = st.recursive(LEAVES, _nodes, max_leaves=6)
NESTED = st.recursive(LEAVES, _nested, max_leaves=3)
POINTS = st.fixed_dictionaries(
    {
        "t": st.fractions(Fraction(1, 9), Fraction(7, 8), max_denominator=50),
        "a": st.fractions(Fraction(1, 9), Fraction(9, 10), max_denominator=50),
        "c": st.fractions(-2, 2, max_denominator=50).filter(bool),
        **{"f" + "'" * k: st.fractions(-2, 2, max_denominator=50) for k in range(3)},
        "q": st.fractions(-2, 2, max_denominator=50),
    }
)
QUICK = settings(
    max_examples=120, deadline=None, derandomize=True, database=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much],
)  # fmt: skip


def _interpreter(*expressions):
    try:
        return Interpreter(SYSTEM, expressions)
    except (UndecidedError, UndefinedError):
        reject()


def _check_derivation(expression):
    derived = DERIVE(expression)
    interpreter = _interpreter(expression, derived)
    try:
        rate = interpreter.field.derive(interpreter.read(expression))
        expected = interpreter.read(derived)
    except (JetOverflowError, UndecidedError):
        reject()
    assert rate == expected, to_text(expression)


def _check_value(expression, point):
    interpreter = _interpreter(expression)
    printed = interpreter.element_expression(interpreter.read(expression))
    with precision(400, 1):
        balls = BallPoint(SYSTEM, point, 1)
        try:
            value = balls.value(expression)[0]
        except (OutsideDomainError, ZeroDivisionError):
            reject()
        assume(value.rad() < 1)
        difference = value - balls.value(printed)[0]
        assert difference.contains(0), f"{to_text(expression)} is not {to_text(printed)}"


@QUICK
@given(PLAIN)
def test_the_derivation_of_the_field_is_the_time_derivative(expression):
    _check_derivation(expression)


@QUICK
@given(PLAIN, POINTS)
def test_the_field_has_the_values_of_the_expression(expression, point):
    _check_value(expression, point)


@settings(QUICK, max_examples=60)
@given(NESTED)
def test_the_derivation_is_right_for_nested_functions(expression):
    _check_derivation(expression)


@settings(QUICK, max_examples=60)
@given(NESTED, POINTS)
def test_values_are_right_for_nested_functions(expression, point):
    _check_value(expression, point)


@QUICK
@given(PLAIN, PLAIN)
def test_reading_is_a_homomorphism(left, right):
    total, product = add(left, right), multiply(left, right)
    interpreter = _interpreter(left, right, total, product)
    read = interpreter.read
    try:
        assert read(left) + read(right) == read(total)
        assert read(left) * read(right) == read(product)
        assert not read(left) - read(left)
        if read(right):
            assert read(left) / read(right) * read(right) == read(left)
    except UndecidedError:
        reject()


@pytest.mark.parametrize(
    "text",
    [
        "exp(sin(c*t))", "log(2 + cos(c*t))", "sqrt(2 + cos(c*t))", "sqrt(1 + sqrt(1 + t^2))", "atan(sin(t))",
        "log(1 + log(1 + t)^2)", "sqrt(1 + exp(t))", "sin(exp(c*t))", "(1 + t)^c", "t^a", "asin(t/2)", "acos(a*t)",
        "atanh(t/3)", "acosh(2 + t)", "log(1 - t)", "log(t - 1/10)", "sqrt(1 - t^2)", "exp(log(1 - t)/3)",
        "(1 - t)^c", "tan(c*t + a)", "deriv(f)^2*sin(f)", "exp(-a*t)*cos(c*t)",
    ],
)  # fmt: skip
def test_particular_functions_have_their_derivatives_and_values(text):
    from obscli.model.covector import parse_scalar

    expression = parse_scalar(SYSTEM, text, "test")
    derived = DERIVE(expression)
    interpreter = Interpreter(SYSTEM, [expression, derived])
    element = interpreter.read(expression)
    assert interpreter.field.derive(element) == interpreter.read(derived)
    printed = interpreter.element_expression(element)
    point = {
        "t": Fraction(1, 3),
        "a": Fraction(2, 5),
        "c": Fraction(-3, 4),
        "f": Fraction(1, 2),
        "f'": Fraction(2),
        "q": Fraction(1),
    }
    with precision(300, 1):
        difference = BallPoint(SYSTEM, point, 1).value(add(expression, negate(printed)))[0]
        assert difference.contains(0), to_text(printed)
