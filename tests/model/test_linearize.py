"""Linearisation: A, H, B, G are the Jacobians at the nominal point, whatever the equations are made of."""

import math
import random

import pytest
import sympy

from obscli.core.place import ModelError
from obscli.model.notation import to_text
from obscli.model.reader import read_text


STATES = ("x", "y", "z")
VALUES = {"t": 0.7, "a": 1.3, "b": 0.6, "f": 0.9}
POINT = {"x": "a*sin(t)", "y": "b - f/3", "z": "1/(1 + t^2)"}
SMOOTH = (
    "sin({})", "cos({})", "tan(sin({})/2)", "exp(sin({}))", "log(2 + cos({}))", "atan({})", "asin(sin({})/2)",
    "acos(cos({})/3)", "sinh(sin({}))", "cosh(cos({}))", "tanh({})", "asinh({})", "acosh(3 + sin({}))",
    "atanh(cos({})/2)", "sqrt(2 + sin({}))", "(3 + sin({}))^(-2/3)", "({})^3", "1/(2 + sin({}))",
    "norm([{}, 1, x])", "2^sin({})", "(2 + cos({}))^sin(y)", "dot([{}, x], [y, {}])",
)  # fmt: skip


def expression(source, depth):
    if depth == 0:
        return source.choice((*STATES, "a", "t", "f", "2/3", "x", "y"))
    if source.random() < 0.5:
        inner = expression(source, depth - 1)
        return source.choice(SMOOTH).replace("{}", inner)
    left, right = (expression(source, depth - 1) for _ in range(2))
    return f"({left} {source.choice('+-**')} {right})"


def in_sympy(text):
    names = {name: sympy.Symbol(name) for name in (*STATES, *VALUES)}
    names |= {
        "norm": lambda v: sympy.sqrt(sum(one**2 for one in v)),
        "dot": lambda v, w: sum(one * other for one, other in zip(v, w, strict=True)),
    }
    return sympy.sympify(text.replace("^", "**"), locals=names)


def system(*lines):
    return read_text("\n".join(lines), "model.yaml").systems[0]


def texts(matrix):
    return {place: to_text(entry) for place, entry in matrix.entries.items()}


@pytest.mark.parametrize("seed", range(30))
def test_jacobians_are_those_of_computer_algebra(seed, dense):
    source = random.Random(seed)
    sides = [expression(source, 3) for _ in range(3)]
    one = system(
        "states: [x, y, z]",
        "parameters: {a: , b: }",
        "functions: [f]",
        f"linearize: {{trajectory: {{x: {POINT['x']}, y: {POINT['y']}, z: {POINT['z']}}}}}",
        "dynamics:",
        *(f"  {name}: '{side}'" for name, side in zip(STATES, sides, strict=True)),
        f"measurements: {{m: '{sides[0]} + 7*({sides[1]})'}}",
    )
    point = {sympy.Symbol(name): in_sympy(text) for name, text in POINT.items()}
    values = {sympy.Symbol(name): value for name, value in VALUES.items()}

    def jacobian(text):
        return [float(sympy.diff(in_sympy(text), name).subs(point).subs(values).evalf()) for name in STATES]

    expected = [jacobian(side) for side in sides]
    for found, row in zip(dense(one.A, VALUES), expected, strict=True):
        assert found == pytest.approx(row, rel=1e-9, abs=1e-9)
    assert dense(one.H, VALUES)[0] == pytest.approx(
        [p + 7 * q for p, q in zip(expected[0], expected[1], strict=True)], rel=1e-9, abs=1e-9
    )


AFFINE = (
    "states: {psi: 3, b: 1}",
    "parameters: {g: 9.8}",
    "inputs: [u]",
    "disturbances: {w: 3}",
    "dynamics:",
    "  psi: '-cross([0, t, g], psi) + b*[1, 2, 3]/g + w + u*[t, 0, 0]'",
    "  b: -b/2 + psi2",
    "measurements: {y: 'rotx(t) @ psi + [b, 0, g*b]', z: b}",
    "quantities: {e: psi1 + g*b}",
)


@pytest.mark.parametrize(
    "point", ["{}", "{psi: [t, g, 0], b: 0}", "{psi2: 3, u: g}", "{b: -t, w: [1, 2, 3]}"]
)
def test_linear_equations_are_their_own_linearisation(point):
    plain = system(*AFFINE)
    about = system(*AFFINE, f"linearize: {{trajectory: {point}}}")
    for name in "AHBG":
        assert texts(getattr(plain, name)) == texts(getattr(about, name))
    assert [dict(q.coefficients).keys() for q in plain.quantities] == [{"psi1", "b"}]


def test_the_value_of_what_enters_linearly_does_not_matter(dense):
    lines = ("states: [x, y, b]", "dynamics: {x: sin(x) + b, y: x*y^2 - 3*b}", "measurements: {m: x*y + b}")
    values = {"t": 0.4}
    without, with_b = (
        system(*lines, f"linearize: {{trajectory: {{x: t, y: 2, {more}}}}}") for more in ("", "b: exp(t)")
    )
    assert dense(without.A, values) == dense(with_b.A, values)
    assert dense(without.H, values) == dense(with_b.H, values)
    assert dense(without.A, values)[:2] == [[math.cos(0.4), 0, 1], [4, 4 * 0.4, -3]]


def test_quaternion_kinematics(dense):
    """q' = ½ q ∘ (0, ω):  ∂/∂q = ½ Ω(ω̄),  ∂/∂ω = ½ Ξ(q̄) with the rows of Wertz, q̄ and ω̄ arbitrary."""
    one = system(
        "states: {q: 4, w: 3}",
        "parameters: {p: , r: , a: , b: , c: , d: }",
        "disturbances: {n: 3}",
        "linearize: {trajectory: {q: '[a, b, c, d]', w: '[p, r, t]'}}",
        "dynamics: {q: 1/2*omega4(w + n) @ q}",
        "measurements: {f: 'quat_matrix(q).T @ [0, 0, 1]'}",
    )
    p, r, t, a, b, c, d = values = (0.3, -0.2, 0.5, 0.7, 0.1, -0.3, 0.6)
    known = dict(zip(("p", "r", "t", "a", "b", "c", "d"), values, strict=True))
    found = dense(one.A, known)
    rates = [[0, -p, -r, -t], [p, 0, t, -r], [r, -t, 0, p], [t, r, -p, 0]]
    frame = [[-b, -c, -d], [a, -d, c], [d, a, -b], [-c, b, a]]
    for row, left, right in zip(found, rates, frame, strict=False):
        assert row == pytest.approx([entry / 2 for entry in (*left, *right)])
    assert one.G is not None
    assert {(i, j): texts(one.A)[i, 4 + j] for i, j in one.G.entries} == texts(one.G)
    # third row of the rotation matrix: 2(q1 q3 - q0 q2), 2(q2 q3 + q0 q1), q0^2 - q1^2 - q2^2 + q3^2
    gradient = [
        [-2 * c, 2 * d, -2 * a, 2 * b],
        [2 * b, 2 * a, 2 * d, 2 * c],
        [2 * a, -2 * b, -2 * c, 2 * d],
    ]
    for row, expected in zip(dense(one.H, known), gradient, strict=True):
        assert row == pytest.approx([*expected, 0, 0, 0])


def test_disturbances_are_zero_on_the_trajectory():
    one = system(
        "states: [x]",
        "inputs: [u]",
        "disturbances: [w]",
        "linearize: {trajectory: {x: 2*t, u: 5}}",
        "dynamics: {x: u*x + x*w + w^2}",
        "measurements: {y: x^2}",
    )
    assert (texts(one.A), texts(one.B), texts(one.G)) == ({(0, 0): "5"}, {(0, 0): "2*t"}, {(0, 0): "2*t"})
    assert texts(one.H) == {(0, 0): "4*t"}


MOVED = (
    "states: [x]",
    "parameters: {a: 1}",
    "let: {where: }",
    "linearize: {trajectory: {x: where}}",
    "dynamics: {x: x^2/2}",
    "measurements: {y: x}",
    "stages:",
    "  here: {let: {where: a}}",
    "  there: {let: {where: 7*t}}",
    "  zero: {let: {where: a}, fix: {a: 0}}",
    "experiment: {runs: [here, {stage: there, name: on, let: {where: 3}}]}",
)


def test_stages_move_the_point_through_let():
    model = read_text("\n".join(MOVED), "model.yaml")
    assert [texts(one.A) for one in model.systems] == [{(0, 0): "a"}, {(0, 0): "7*t"}, {}]
    assert model.experiment is not None
    assert [texts(run.system.A) for run in model.experiment.runs] == [{(0, 0): "a"}, {(0, 0): "3"}]


@pytest.mark.parametrize(
    "side", ["norm([x, x^2])", "sqrt(x^2)", "sqrt(x)", "acos(1 - x^2)", "asin(1 - x)", "(x^4)^(1/4)"]
)
def test_no_derivative_at_the_point(side):
    """Also where all first derivatives of what stands inside are zero."""
    with pytest.raises(ModelError, match="no derivative at the nominal point"):
        system("states: [x]", "linearize: {trajectory: {x: 0}}", f"dynamics: {{x: '{side}'}}",
               "measurements: {y: x}")  # fmt: skip


@pytest.mark.parametrize(
    ("side", "slope"), [("x^2", None), ("x^(3/2)", None), ("cos(x)", None), ("x^0", None), ("sin(x)", "1"),
                        ("(1 + x)^5", "5"), ("exp(x)^2", "2"), ("1/(x + 2)", "-1/4"), ("acos(x)", "-1")]
)  # fmt: skip
def test_exact_slopes_at_zero(side, slope):
    one = system("states: [x]", "linearize: {trajectory: {x: 0}}", f"dynamics: {{x: '{side}'}}",
                 "measurements: {y: x}")  # fmt: skip
    assert texts(one.A) == ({} if slope is None else {(0, 0): slope})
