"""What becomes of hidden errors: transition matrices known in closed form, and laws."""

import numpy as np
import pytest
from scipy.linalg import expm

from obscli.checks.detectability import seen_detectability
from obscli.exact.analysis import Options, analyze
from obscli.model.reader import read_text
from obscli.numeric.errors import NotComputableError
from obscli.numeric.hidden_motion import hidden_motion


def moved(text, start, stop, *, period=False):
    """The hidden motion of a model text, along the directions that the exact side finds."""
    system = read_text(text, "test.yaml").systems[0]
    analysis = analyze(system, Options(critical=False, certificate=False))
    return hidden_motion(system, analysis.unobservable, start, stop, period=period)


def hidden(A22, *, observed="-y", drive="0", scale=""):
    """A pair h' = A22 h behind a measured state."""
    return (
        f"states: {{y: {{scale: 1}}, h1: {{scale: {scale or 1}}}, h2: {{scale: {scale or 1}}}}}\n"
        f"dynamics:\n  y: {observed}\n  h1: ({A22[0][0]})*h1 + ({A22[0][1]})*h2 + {drive}\n"
        f"  h2: ({A22[1][0]})*h1 + ({A22[1][1]})*h2\nmeasurements: {{z: y}}\n"
    )


#: h = R(t) e^(-t/4 …): grows though every frozen pair of eigenvalues has real part -1/4.
MARKUS_YAMABE = [
    ["-1 + 3/2*cos(t)^2", "1 - 3/2*sin(t)*cos(t)"],
    ["-1 - 3/2*sin(t)*cos(t)", "-1 + 3/2*sin(t)^2"],
]
#: dies out like exp(-t), though one frozen eigenvalue is 2 at every instant.
WU = [
    ["-11/2 + 15/2*sin(12*t)", "15/2*cos(12*t)"],
    ["15/2*cos(12*t)", "-11/2 - 15/2*sin(12*t)"],
]


@pytest.mark.parametrize("start", [0, 0.7, 5])
@pytest.mark.parametrize(
    ("A22", "period", "multipliers"),
    [
        (MARKUS_YAMABE, 2 * np.pi, [np.exp(np.pi), np.exp(-2 * np.pi)]),
        (WU, np.pi / 6, [-np.exp(-np.pi / 6), -np.exp(-10 * np.pi / 6)]),
    ],
)
def test_floquet_multipliers_are_the_known_ones_wherever_the_period_starts(A22, period, multipliers, start):
    found = moved(hidden(A22), start, start + period, period=True)
    assert found.multipliers == pytest.approx(multipliers, rel=1e-9)
    assert found.multiplier_error < 1e-9


def test_the_solution_that_grows_is_the_one_that_is_known():
    """h = e^(t/2) (-cos t, sin t) solves Markus and Yamabe's equations."""
    found = moved(hidden(MARKUS_YAMABE), 0, 2 * np.pi, period=True)
    assert found.gains[0] == pytest.approx(np.exp(np.pi), rel=1e-10)
    assert found.directions[0] == pytest.approx({"h1": 1})


@pytest.mark.parametrize(("T", "largest"), [(1, 16.7), (5, 1.065), (20, 5.1e-7)])
def test_a_hidden_error_may_grow_before_it_dies_out(T, largest):
    found = moved(hidden([["-1", "50"], ["0", "-1.2"]]), 0, T)
    assert found.gains[0] == pytest.approx(largest, rel=1e-2)
    exact = np.linalg.svd(expm(T * np.array([[-1, 50], [0, -1.2]])), compute_uv=False)
    assert found.gains == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize("rate", ["5*y", "40*y", "-40*y"])
def test_what_is_observed_may_grow_or_decay_without_a_trace(rate):
    """Rounding along an observed direction that grows by e^400 does not come into the hidden ones."""
    found = moved(hidden([["-2", "0"], ["0", "-2"]], observed=rate, drive="3*y"), 0, 10)
    assert found.gains == pytest.approx([np.exp(-20)] * 2, rel=1e-6)


def test_windows_follow_each_other():
    """G(t2, t0) = G(t2, t1) G(t1, t0): their determinants multiply."""
    text = hidden([["-1/2", "t"], ["-cos(t)", "1/3"]])
    first, second, both = (moved(text, *window) for window in ((0, 1), (1, 3), (0, 3)))
    assert np.prod(both.gains) == pytest.approx(np.prod(first.gains) * np.prod(second.gains), rel=1e-9)


def test_the_scale_of_all_states_does_not_matter_and_their_ratios_do():
    A22 = [["-1", "50"], ["0", "-1.2"]]
    plain = moved(hidden(A22), 0, 1)
    larger = moved(hidden(A22).replace("scale: 1", "scale: 1000"), 0, 1)
    assert larger.gains == pytest.approx(plain.gains, rel=1e-12)
    ratio = hidden(A22).replace("h1: {scale: 1}", "h1: {scale: 50}")
    assert moved(ratio, 0, 1).gains[0] < plain.gains[0] / 10


def test_directions_that_turn_are_followed():
    """x1 = cos(t), x2 = sin(t) of the hidden constant: nothing shrinks or grows, though N(t) turns."""
    text = "states: [x1, x2]\nA: zeros(2, 2)\nH: [[cos(t), sin(t)]]\n"  # y = x1 cos t + x2 sin t sees both
    system = read_text(text, "test.yaml").systems[0]
    assert analyze(system, Options(critical=False)).rank == 2
    turning = "states: [x1, x2]\ndynamics: {x1: -x2, x2: x1}\nmeasurements: {y: cos(t)*x1 + sin(t)*x2}\n"
    found = moved(turning, 0.3, 7)
    assert found.gains == pytest.approx([1.0], rel=1e-12)
    assert found.directions[0] == pytest.approx({"x1": -np.tan(0.3), "x2": 1}, rel=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_a_change_of_basis_changes_no_multiplier(seed):
    source = np.random.default_rng(seed)
    T = source.integers(-2, 3, (3, 3)) + 4 * np.eye(3, dtype=int)
    S = np.linalg.inv(T)
    A = np.array([[-3.0, 0, 0], [1, -1, 1], [2, 0, -0.5]])
    text = (
        f"states: [a, b, c]\nA: {rational(T, A)}\nH: {[[f'{v}/{round(np.linalg.det(T))}' for v in row] for row in adjugate(T)[:1]]}\n"
    ).replace("'", "")
    found = moved(text, 0, 2, period=True)
    assert found.multipliers == pytest.approx([np.exp(-1.0), np.exp(-2.0)], rel=1e-9)
    assert np.allclose(S @ T, np.eye(3))


def adjugate(T):
    """det(T) T⁻¹, in whole numbers."""
    return np.round(np.linalg.inv(T) * np.linalg.det(T)).astype(int)


def rational(T, A):
    """T A T⁻¹ as exact fractions."""
    top = np.round(T @ (2 * A) @ adjugate(T)).astype(int)
    return [[f"{v}/{2 * round(np.linalg.det(T))}" for v in row] for row in top]


@pytest.mark.parametrize(
    ("a", "T", "verdict"),
    [
        ("-1", 5, "detectable"),
        ("-1", 0.1, "undecided"),
        ("0", 5, "not detectable"),
        ("1/10", 5, "not detectable"),
        ("-1e-12", 1, "undecided"),
    ],
)
def test_the_verdict_on_a_window_says_no_more_than_the_window_shows(a, T, verdict):
    text = hidden([[a, "0"], ["0", "-3"]])
    structure = analyze(read_text(text, "test.yaml").systems[0], Options(critical=False)).structure
    found = seen_detectability(structure, moved(text, 0, T))
    assert found.scope == f"this window, 0 to {T:g}"
    assert found.verdict in ({verdict} | ({"not detectable"} if a == "-1e-12" else set()))


def test_directions_that_are_none_of_the_system_are_refused():
    system = read_text(hidden([["-1", "0"], ["0", "-1"]], observed="h1"), "test.yaml").systems[0]
    wrong = read_text(hidden([["-1", "0"], ["0", "-1"]]), "test.yaml").systems[0]
    directions = analyze(wrong, Options(critical=False)).unobservable
    with pytest.raises(NotComputableError, match="not resolved"):
        hidden_motion(system, directions, 0, 1)
