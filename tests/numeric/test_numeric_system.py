"""A(t), H(t) in floating point are the model's, and what does not exist is named with its place and instant."""

import mpmath
import numpy as np
import pytest

from obscli.model.covector import parse_covector
from obscli.numeric.errors import NotComputableError
from obscli.numeric.numeric_system import NumericSystem


INS = "ins_calibration/horizontal.yaml"
VALUES = [{}, {"omega": "0.9", "omega_ie": "0.35", "phi": "1.1", "g": "9.7"}]


@pytest.mark.parametrize("values", VALUES)
def test_ins_stage_1_is_the_one_coded_by_hand(bundled, stage_1, values):
    found = NumericSystem(bundled(INS, "stage_1", settings=values), 0, 1500)
    params = stage_1.NOMINAL | {name: float(value) for name, value in values.items()}
    t = np.random.default_rng(0).uniform(0, 1500, 20)
    c = found.coefficients(t)
    for k, one in enumerate(t):
        A, H = np.zeros((24, 24)), stage_1.H(one, params)
        A[found.moving] = c.A[k]
        # angles up to 1350 are rounded to 1e-13, which the rates of A (at most 1) and H show
        assert np.abs(A - stage_1.A(one, params)).max() < 4e-13
        assert np.abs(c.H[k] - H).max() < 4e-13
    assert list(found.moving) == [0, 1, 2]
    assert list(found.constant_states) == list(range(3, 24))


def test_errors_of_entries_are_honest(bundled):
    """cos(omega t) at t = 1500 is wrong by the rounding of the instant and of the angle, not by that of 1."""
    found = NumericSystem(bundled(INS, "stage_1"), 0, 1500)
    c = found.coefficients(np.array([1500 / 7, 1400.1]))
    with mpmath.workdps(40):
        for k, t in enumerate((1500 / 7, 1400.1)):
            angle = mpmath.mpf(1) / 10 * mpmath.mpf(t)
            exact = mpmath.cos(angle) / mpmath.mpf("9.81")  # H[y2, b_a2], R_22/g
            off = float(abs(mpmath.mpf(c.H[k, 1, 7]) - exact))
            assert off <= 10 * c.H_error[k, 1, 7]
            assert c.H_error[k, 1, 7] < 1e-14


def test_errors_of_functions_are_passed_on(system):
    """Tones are rounded; what follows a rule or a relation has the error of that."""
    body = "states: [x]\nA: [[0]]\nH: [[f]]\n"
    t, least = np.linspace(1, 9, 5), []
    for functions in ("[f]", "{f: {invariant: f^2 - 2 - sin(t)}}", "{f: {derivative: -f}}"):
        c = NumericSystem(system(f"functions: {functions}\n{body}"), 0, 10).coefficients(t)
        least.append((c.H_error / np.abs(c.H)).min())
    assert least[0] == pytest.approx(np.finfo(float).eps / 4)
    assert least[1] == pytest.approx(1e-15)
    assert least[2] >= 3e-15  # one rounding a panel, some panels


def test_matrices_are_the_coefficients_without_errors(bundled):
    found = NumericSystem(bundled(INS, "stage_2"), 0, 1500)
    t = np.linspace(1, 1500, 7)
    c = found.coefficients(t)
    for mine, other in zip(found.matrices(t), (c.A, c.H), strict=True):
        assert (mine == other).all()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "parameters: {a: , b: 2}\nstates: [x]\nA: [[a*b]]\nH: [[1]]\n",
            "parameter without a value: a; give it in the file or with --set a=…",
        ),
        (
            "parameters: {a: , b: , unused: }\nstates: [x]\nA: [[a]]\nH: [[b]]\n",
            "parameters without a value: a, b; give them in the file or with --set a=… --set b=…",
        ),
        (
            "parameters: {a: }\nfunctions: {f: {derivative: a*f}}\nstates: [x]\nA: [[f]]\nH: [[1]]\n",
            "parameter without a value: a; give it in the file or with --set a=…",
        ),
        (
            "parameters: {a: }\nfunctions: {f: {invariant: f - a}}\nstates: [x]\nA: [[f]]\nH: [[1]]\n",
            "parameter without a value: a; give it in the file or with --set a=…",
        ),
    ],
)
def test_parameters_without_a_value_are_named(system, text, message):
    with pytest.raises(NotComputableError) as error:
        NumericSystem(system(text), 0, 1)
    assert str(error.value) == message


def test_a_parameter_that_is_not_used_needs_no_value(system):
    found = NumericSystem(system("parameters: {a: }\nstates: [x]\nA: [[1]]\nH: [[1]]\n"), 0, 1)
    assert found.coefficients(np.array([0.5])).A[0, 0, 0] == 1


def test_a_value_given_later_is_used(system):
    text = "parameters: {a: }\nstates: [x]\nA: [[a]]\nH: [[1]]\n"
    found = NumericSystem(system(text, settings={"a": "1/3"}), 0, 1)
    assert found.coefficients(np.array([0.5])).A[0, 0, 0] == 1 / 3


@pytest.mark.parametrize(
    ("A", "H", "place"),
    [
        ("1/(t - 2)", "1", r"A\[x, x\] does not exist at t = 2:"),
        ("1", "log(2 - t)", r"H\[y1?, x\] does not exist at t = 2:"),
        ("0", "sqrt(1 - t)", r"H\[y1?, x\] does not exist at t = 2:"),
        ("exp(exp(5*t))", "1", r"A\[x, x\] does not exist at t = 2:"),
    ],
)
def test_an_entry_that_does_not_exist_is_named_with_its_instant(system, A, H, place):
    found = NumericSystem(system(f"states: [x]\nA: [['{A}']]\nH: [['{H}']]\n"), 0, 4)
    for evaluate in (found.coefficients, found.matrices):
        with pytest.raises(NotComputableError, match=place):
            evaluate(np.array([0.5, 2.0, 3.0]))
        evaluate(np.array([0.5, 0.75]))


def test_rows_that_are_zero_are_not_moving(system):
    text = "states: [a, b, c, d]\nA: {b: {a: 1}, d: {d: t}}\nH: {y: {a: 1}}\n"
    found = NumericSystem(system(text), 0, 1)
    assert list(found.moving) == [1, 3]
    assert list(found.constant_states) == [0, 2]
    c = found.coefficients(np.array([0.25, 0.5]))
    np.testing.assert_array_equal(c.A[1], [[1, 0, 0, 0], [0, 0, 0, 0.5]])
    assert not found.is_constant


@pytest.mark.parametrize(
    ("A", "functions", "constant"), [("sin(a)", "[]", True), ("t", "[]", False), ("f", "[f]", False)]
)
def test_constant_systems_are_known(system, A, functions, constant):
    text = f"parameters: {{a: 2}}\nfunctions: {functions}\nstates: [x]\nA: [['{A}']]\nH: [[1]]\n"
    assert NumericSystem(system(text), 0, 1).is_constant == constant


def test_linear_forms_are_evaluated_at_instants(bundled):
    given = bundled(INS, "stage_2")
    found = NumericSystem(given, 0, 1500)
    form = parse_covector(given, "g*psi2 - b_a2 - g*sin(omega*t)*M_a21", "test").coefficients
    rows, errors = found.covectors([form], np.array([3.0, 700.0]))
    names = list(given.state_names)
    expected = np.zeros((2, 1, 24))
    expected[:, 0, names.index("psi2")] = 9.81
    expected[:, 0, names.index("b_a2")] = -1
    expected[:, 0, names.index("M_a21")] = -9.81 * np.sin(0.1 * np.array([3.0, 700.0]))
    np.testing.assert_allclose(rows, expected, atol=1e-13)
    assert (errors[rows == 0] == 0).all()
    assert 0 < errors[1].max() < 1e-12


def test_a_form_that_does_not_exist_everywhere_is_not_finite_there(system):
    given = system("states: [x, y]\nA: zeros(2, 2)\nH: [[1, t]]\n")
    form = parse_covector(given, "x/(t - 1) + y", "test").coefficients
    rows, errors = NumericSystem(given, 0, 2).covectors([form], np.array([0.5, 1.0]))
    assert list(np.isfinite(rows[:, 0]).all(axis=1)) == [True, False]
    assert np.isfinite(errors).all()


def test_a_parameter_beyond_doubles_is_named(system):
    given = system("parameters: {a: 10^400}\nstates: [x]\nA: [[a]]\nH: [[1]]\n")
    with pytest.raises(NotComputableError, match="the value of a is not finite in double precision"):
        NumericSystem(given, 0, 1)
