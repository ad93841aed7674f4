import math
from fractions import Fraction

import pytest

from obscli.core.place import ModelError
from obscli.model.expression import Number
from obscli.model.syntax import parse
from obscli.model.tokens import Mistake


VALUES = {"t": 0.7, "a": 1.3, "b": -0.4, "c": 2.1, "f": 0.6, "g": 1.7, ("f", 1): 0.2, ("f", 2): -0.9}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("-a^2", -(1.3**2)),
        ("2^3^2", 512),
        ("2^-1", 0.5),
        ("2^-2^2", 2**-4),
        ("-2^2", -4),
        ("(-2)^2", 4),
        ("a**2*b", 1.3**2 * -0.4),
        ("a - b - c", 1.3 + 0.4 - 2.1),
        ("a - (b - c)", 1.3 + 0.4 + 2.1),
        ("a/b/c", 1.3 / -0.4 / 2.1),
        ("a/b*c", 1.3 / -0.4 * 2.1),
        ("a/(b*c)", 1.3 / (-0.4 * 2.1)),
        ("--a", 1.3),
        ("+-+a", -1.3),
        ("2*-a", -2.6),
        ("a*-b^2", 1.3 * -(0.4**2)),
        ("1e-3 + .5 + 2.", 2.501),
        ("0.1*3", 0.3),
        ("pi/2", math.pi / 2),
        ("c^a", 2.1**1.3),
        ("2^a", 2**1.3),
        ("c^(1/3)", 2.1 ** (1 / 3)),
        ("sqrt(c)", math.sqrt(2.1)),
        ("exp(a) + log(c)", math.exp(1.3) + math.log(2.1)),
        ("sin(a)^2 + cos(a)^2", 1),
        ("tan(a) - sin(a)/cos(a)", 0),
        ("asin(b) + acos(b)", math.pi / 2),
        ("atan(a)", math.atan(1.3)),
        ("cosh(a)^2 - sinh(a)^2", 1),
        ("tanh(a)", math.tanh(1.3)),
        ("asinh(a) + acosh(c) + atanh(b)", math.asinh(1.3) + math.acosh(2.1) + math.atanh(-0.4)),
        ("cross([a, b, c], [1, 2, 3])[1]", -0.4 * 3 - 2.1 * 2),
        ("(skew([a, b, c]) @ [1, 2, 3])[2]", 2.1 - 1.3 * 3),
        ("dot([a, b], [b, c])", 1.3 * -0.4 + -0.4 * 2.1),
        ("norm([a, b, c])^2", 1.3**2 + 0.4**2 + 2.1**2),
        ("norm([3, 4])", 5),
        ("[a, b] @ [b, c]", 1.3 * -0.4 + -0.4 * 2.1),
        ("([[a, b], [c, 1]] @ [1, 2])[2]", 2.1 + 2),
        ("([1, 2] @ [[a, b], [c, 1]])[1]", 1.3 + 2 * 2.1),
        ("([[a, b], [c, 1]] @ [[0, 1], [1, 0]])[1, 1]", -0.4),
        ("[[a, b], [c, 1]].T[1, 2]", 2.1),
        ("transpose([[a, b], [c, 1]])[2, 1]", -0.4),
        ("([a, b] @ [1, c].T)[2, 2]", -0.4 * 2.1),
        ("([a, b].T @ [1, c])[1]", 1.3 - 0.4 * 2.1),
        ("eye(3)[2, 2] + eye(3)[1, 2] + zeros(2, 3)[2, 3] + zeros(4)[4]", 1),
        ("diag(a, b)[2, 2] + diag([a, b])[1, 1] + diag(a, b)[1, 2]", 0.9),
        ("block([[eye(2), [a, b]], [0, c]])[1, 3]", 1.3),
        ("block([[eye(2), [a, b]], [0, c]])[3, 3]", 2.1),
        ("block([[eye(2), [a, b]], [0, c]])[3, 1] + 1", 1),
        ("rotx(a)[2, 3]", -math.sin(1.3)),
        ("roty(a)[1, 3]", math.sin(1.3)),
        ("roty(a)[3, 1]", -math.sin(1.3)),
        ("rotz(a)[1, 2]", -math.sin(1.3)),
        ("rotz(a)[2, 1]", math.sin(1.3)),
        ("rotz(a)[1, 1]", math.cos(1.3)),
        ("quat_matrix([cos(a/2), 0, 0, sin(a/2)])[1, 2]", -math.sin(1.3)),
        ("quat_matrix([cos(a/2), sin(a/2), 0, 0])[3, 2]", math.sin(1.3)),
        ("quat_matrix([cos(a/2), 0, sin(a/2), 0])[1, 3]", math.sin(1.3)),
        ("(omega4([a, b, c]) @ [1, 0, 0, 0])[3]", -0.4),
        ("(omega4([a, b, c]) @ [0, 1, 0, 0])[1]", -1.3),
        ("deriv(t^3)", 3 * 0.49),
        ("deriv(f)", 0.2),
        ("deriv(deriv(f))", -0.9),
        ("deriv(a*sin(f))", 1.3 * math.cos(0.6) * 0.2),
        ("deriv(exp(2*f)/f)", (2 * 0.2 * 0.6 - 0.2) * math.exp(1.2) / 0.36),
        ("deriv([t, t^2])[2]", 1.4),
        ("deriv(sqrt(t) + log(t) + tan(t) + atan(t))",
         0.5 / math.sqrt(0.7) + 1 / 0.7 + 1 + math.tan(0.7) ** 2 + 1 / 1.49),
        ("deriv(asin(t) + acos(t) + sinh(t) - cosh(t))", math.cosh(0.7) - math.sinh(0.7)),
        ("deriv(tanh(t) + asinh(t) + atanh(t))",
         1 - math.tanh(0.7) ** 2 + 1 / math.sqrt(1.49) + 1 / (1 - 0.49)),
        ("deriv(acosh(t + 1))", 1 / math.sqrt(1.7**2 - 1)),
    ],
)  # fmt: skip
def test_value(scalar, number, text, expected):
    assert number(scalar(text), VALUES) == pytest.approx(expected, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("0.1", Fraction(1, 10)),
        ("1e-3", Fraction(1, 1000)),
        ("1.25E+2", 125),
        ("0.1 + 0.2", Fraction(3, 10)),
        ("sin(pi/6)", Fraction(1, 2)),
        ("cos(3*pi)", -1),
        ("sin(pi/2 + pi)", -1),
        ("tan(pi/4)", 1),
        ("sqrt(9/4)", Fraction(3, 2)),
        ("(9/4)^(-3/2)", Fraction(8, 27)),
        ("exp(0) + cos(0) + log(1) + acos(1) + sinh(0)", 2),
        ("norm([3, 4])", 5),
        ("deriv(a)*f + deriv(3) + 7", 7),
        ("a^0", 1),
    ],
)
def test_exact_number(scalar, text, expected):
    node = scalar(text)
    assert isinstance(node, Number)
    assert node.value == expected


def test_square_root_of_a_square_root_squared(scalar, number):
    assert number(scalar("sqrt(2)^2 - 2 + 5"), {}) == pytest.approx(5)
    assert number(scalar("sqrt(12)*sqrt(1/2) + sin(pi/4) + cos(pi/6)"), {}) == pytest.approx(
        math.sqrt(6) + math.sqrt(0.5) + math.sqrt(0.75)
    )


@pytest.mark.parametrize(
    "text",
    [
        "",
        "  ",
        "a b",
        "2a",
        "(a",
        "a)",
        "a +",
        "* a",
        "[a",
        "a..T",
        "a.b",
        "f(,)",
        "'a'",
        "a = b",
        "a < b",
        "{a}",
    ],
)
def test_no_expression(text):
    with pytest.raises(Mistake):
        parse(text)


def test_users_names(number):
    """Python's keywords, Greek and single letters are ordinary names; only functions are reserved."""
    from obscli.model.reader import read_text

    names = [
        "beta",
        "gamma",
        "lambda",
        "S",
        "N",
        "E",
        "I",
        "Q",
        "in",
        "φ",
        "ω_ie",
        "is",
        "None",
        "abs",
        "e",
        "_u",
        "é",
    ]
    text = f"parameters: {{{', '.join(f'{n}: {k}' for k, n in enumerate(names, 1))}}}\nstates: [x]\nA: [[{'+'.join(names)}]]\nH: [[1]]"
    system = read_text(text, "names").systems[0]
    values = {n: k for k, n in enumerate(names, 1)}
    assert [p.name for p in system.parameters] == names
    assert number(system.A.entries[0, 0], values) == sum(values.values())


def test_names_are_normalised(number):
    """A letter with a combining accent is the same name as the composed letter."""
    from obscli.model.reader import read_text

    text = "parameters: {e\u0301: 1}\nstates: [x]\nA: [[2*\u00e9]]\nH: [[1]]"
    system = read_text(text, "nfc").systems[0]
    assert number(system.A.entries[0, 0], {"\u00e9": 3}) == 6


def test_a_power_of_ten_thousand_is_the_limit(scalar, number):
    assert number(scalar("t^10000"), {"t": 1.0}) == 1
    with pytest.raises(ModelError, match="powers beyond 10000"):
        scalar("t^10001")


def test_nesting_of_a_hundred_is_the_limit(scalar, number):
    assert number(scalar("(" * 99 + "a" + ")" * 99), {"a": 2.0}) == 2
    with pytest.raises(ModelError, match="nested over 100 deep"):
        scalar("(" * 100 + "a" + ")" * 100)
