"""A solution followed from a state: the outputs show nothing of an unobservable direction, and something of others."""

import numpy as np
import pytest
from scipy.linalg import expm

from obscli.numeric.errors import TooManyStepsError
from obscli.numeric.trajectory import follow


A = np.array([[0, 1, 0, 1], [-4, -0.2, 1, 2], [0, 0, -0.5, -1], [0, 0, 0, 0]])
TEXT = f"states: [a, b, c, d]\nA: {A.tolist()}\nH: [[1, 0, 0, 0]]\ninterval: {{stop: 6}}\n"


def test_a_time_invariant_solution_is_the_exponential(numeric):
    x = np.array([1.0, -2.0, 0.0, 0.5])
    found = follow(numeric(TEXT), x, 13)
    np.testing.assert_allclose(found.instants, np.linspace(0, 6, 13))
    expected = np.array([expm(A * t) @ x for t in found.instants])
    np.testing.assert_allclose(found.states, expected, atol=1e-12)


def test_a_time_varying_solution_in_closed_form(numeric):
    """x' = cos(t) x, z' = x e^(−sin t): x = x0 e^(sin t), z = z0 + x0 t."""
    text = "states: [x, z]\nA: [[cos(t), 0], [exp(-sin(t)), 0]]\nH: [[1, 0]]\ninterval: {stop: 10}\n"
    found = follow(numeric(text), np.array([2.0, 1.0]), 21)
    t = found.instants
    expected = np.array([2 * np.exp(np.sin(t)), 1 + 2 * t]).T
    np.testing.assert_allclose(found.states, expected, rtol=1e-11)
    assert found.output == pytest.approx(1)


def test_the_first_state_is_the_given_one_and_the_start_may_lie_anywhere(numeric):
    x = np.array([3.0, 0.0, -1.0, 0.0])
    found = follow(numeric(TEXT, start=-2, stop=1), x, 2)
    np.testing.assert_array_equal(found.states[0], x)
    np.testing.assert_allclose(found.states[1], expm(A * 3) @ x, atol=1e-12)
    np.testing.assert_array_equal(found.instants, [-2, 1])


INS = [
    ({"psi3": 1, "b_g2": lambda p: p["omega_ie"] * np.cos(p["phi"])}, True),
    ({"M_g12": 1, "b_g1": lambda p: -p["omega"]}, True),
    ({"M_a22": 1}, True),
    ({"psi3": 1}, False),
    ({"M_g12": 1, "b_g1": lambda p: p["omega"]}, False),
    ({"psi1": 1}, False),
]


@pytest.mark.parametrize(("direction", "hidden"), INS)
def test_hidden_directions_of_the_ins_cause_no_output(numeric, bundled, direction, hidden):
    found = numeric(bundled("ins_calibration/horizontal.yaml", "stage_2"), samples=5)
    names, x = found.system.system.state_names, np.zeros(24)
    for name, value in direction.items():
        x[names.index(name)] = value(found.system.constants) if callable(value) else value
    output = follow(found, x, 31).output
    # relative to what each initial state alone would cause, which is what cancels
    assert output < 1e-10 if hidden else output > 1e-3


def test_an_exact_direction_is_followed_unseen(numeric, exact, bundled):
    """All directions that algebra calls unobservable, at the start of the interval."""
    for path, stage in (("textbook/levelling.yaml", None), ("textbook/mixed_coefficients.yaml", None), ("ins_calibration/vertical.yaml", "stage_1")):  # fmt: skip
        given = bundled(path, stage)
        found, proved = numeric(given, samples=5), exact(given)
        start = np.array([found.horizon.start])
        directions = found.system.covectors(proved.unobservable, start)[0][0]
        assert len(directions) == given.n - proved.rank
        for x in directions:
            assert follow(found, x, 21).output < 1e-10
        seen = found.system.covectors([proved.combinations[0].coefficients], start)[0][0, 0]
        assert follow(found, seen, 21).output > 1e-6


def test_a_state_that_stays_zero_shows_nothing(numeric):
    found = follow(numeric(TEXT), np.zeros(4), 3)
    assert found.output == 0
    assert not found.states.any()


def test_too_many_steps_are_refused(numeric):
    """The Gramian falls back on windows; a solution cannot."""
    found = numeric("states: [x]\nA: [['cos(1000*t)']]\nH: [[1]]\n", start=0, stop=1000, samples=3)
    assert found.window is not None
    with pytest.raises(TooManyStepsError):
        follow(found, np.array([1.0]), 3)
