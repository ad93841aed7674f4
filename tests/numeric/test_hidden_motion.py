"""What becomes of hidden errors: transition matrices known in closed form, and laws."""

import numpy as np
import pytest
from scipy.linalg import expm

from obscli.checks.detectability import seen_detectability
from obscli.exact.analysis import Options, analyze
from obscli.model.covector import parse_scalar
from obscli.model.expression import multiply
from obscli.model.reader import read_text
from obscli.model.specialise import at_nominal
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
        ("-1e-9", 1, "undecided"),
    ],
)
def test_the_verdict_on_a_window_says_no_more_than_the_window_shows(a, T, verdict):
    text = hidden([[a, "0"], ["0", "-3"]])
    structure = analyze(read_text(text, "test.yaml").systems[0], Options(critical=False)).structure
    found = seen_detectability(structure, moved(text, 0, T))
    assert found.scope == f"this window, 0 to {T:g}"
    assert found.verdict == verdict


def test_directions_that_are_none_of_the_system_are_refused():
    system = read_text(hidden([["-1", "0"], ["0", "-1"]], observed="h1"), "test.yaml").systems[0]
    wrong = read_text(hidden([["-1", "0"], ["0", "-1"]]), "test.yaml").systems[0]
    directions = analyze(wrong, Options(critical=False)).unobservable
    with pytest.raises(NotComputableError, match="not resolved"):
        hidden_motion(system, directions, 0, 1)


def scrambled(A22, T, *, y="-y"):
    """The pair h' = A22 h behind a state, in coordinates (y, h) = T x, T unimodular."""
    names = ["a", "b", "c"]
    old = ["(" + " + ".join(f"({T[i][j]})*{names[j]}" for j in range(3)) + ")" for i in range(3)]
    rates = [
        y.replace("y", old[0]),
        *(f"({row[0]})*{old[1]} + ({row[1]})*{old[2]} + {old[0]}" for row in A22),
    ]
    S = adjugate(T) * round(np.linalg.det(T))
    new = [" + ".join(f"({S[i][j]})*({rates[j]})" for j in range(3)) for i in range(3)]
    dynamics = "".join(f"  {name}: {rate}\n" for name, rate in zip(names, new, strict=True))
    return f"states: [a, b, c]\ndynamics:\n{dynamics}measurements: {{z: {old[0]}}}\n"


UNIMODULAR = np.array([[1, 2, -1], [1, 3, 1], [0, 1, 3]])


@pytest.mark.parametrize("start", [0, 1.3])
@pytest.mark.parametrize("rate", ["-y", "3*y"])
@pytest.mark.parametrize(
    ("A22", "period", "exponents", "kinds"),
    [
        (MARKUS_YAMABE, 2 * np.pi, [0.5, -1], ["growing", "decaying"]),
        (WU, np.pi / 6, [-1, -10], ["decaying", "decaying"]),
    ],
)
def test_frozen_eigenvalues_mislead_in_any_coordinates(A22, period, exponents, kinds, rate, start):
    assert round(np.linalg.det(UNIMODULAR)) == 1
    found = moved(scrambled(A22, UNIMODULAR, y=rate), start, start + period, period=True)
    assert [one.exponent.real for one in found.floquet] == pytest.approx(exponents, rel=1e-9)
    assert [one.kind for one in found.floquet] == kinds


@pytest.mark.parametrize("seed", range(4))
def test_whichever_basis_of_the_directions_is_given_the_motion_is_the_same(seed):
    """N(t) and N(t) K(t), K regular: the same subspace."""
    system = read_text(hidden(MARKUS_YAMABE), "test.yaml").systems[0]
    a, b = analyze(system, Options(critical=False, certificate=False)).unobservable
    source = np.random.default_rng(seed)
    v, w = source.integers(2, 5, 2)
    turning = parse_scalar(system, f"{v} + sin({w}*t)", "test")
    mixed = {**{name: multiply(turning, value) for name, value in a.items()}, **b}
    plain = hidden_motion(system, (a, b), 0, 2 * np.pi, period=True)
    found = hidden_motion(system, (mixed, b), 0, 2 * np.pi, period=True)
    assert found.gains == pytest.approx(plain.gains, rel=1e-10)
    assert found.multipliers == pytest.approx(plain.multipliers, rel=1e-10)


@pytest.mark.parametrize(("A", "T"), [([[1, 3], [1, -2]], 20), ([[-4, 3], [1, -2]], 20)])
def test_small_factors_are_as_accurate_as_large_ones(A, T):
    """From 4e15 to 5e-25 beside each other: the volume is e^(T tr A), the eigenvalues those of A."""
    found = moved(hidden([[str(v) for v in row] for row in A]), 0, T, period=True)
    rates = sorted(np.linalg.eigvals(A), reverse=True)
    assert [one.exponent.real for one in found.floquet] == pytest.approx(rates, rel=1e-12)
    volume = np.log(found.gains[0]) + np.log(found.gains[1])
    assert volume == pytest.approx(T * np.trace(A), abs=1e-10)
    assert all(error < 1e-9 for error in found.errors)


@pytest.mark.parametrize("rate", [5, -5])
def test_where_no_number_is_so_large_or_so_small_the_exponents_are_right(rate):
    text = hidden([[str(rate), "1/(1 + t^2)"], ["0", str(rate)]])
    found = moved(text, 0, 600)
    assert found.gains == ((np.inf,) * 2 if rate > 0 else (0.0,) * 2)
    assert sum(found.exponents) == pytest.approx(2 * rate, rel=1e-12)
    structure = analyze(read_text(text, "test.yaml").systems[0], Options(critical=False)).structure
    judged = seen_detectability(structure, found)
    assert judged.verdict == ("not detectable" if rate > 0 else "detectable")
    assert f"10^{'-' * (rate < 0)}130" in judged.words


def test_columns_that_meet_at_the_start_or_the_end_are_followed_all_the_same():
    """(1, t) and (1, -t) span the same as (1, 0) and (0, 1), but at t = 0."""
    text = hidden([["-1", "t"], ["0", "-1/2"]])
    system = read_text(text, "test.yaml").systems[0]
    one, t = parse_scalar(system, "1", "test"), parse_scalar(system, "t", "test")
    minus = parse_scalar(system, "-t", "test")
    meeting = ({"h1": one, "h2": t}, {"h1": one, "h2": minus})
    for window in [(0, 2), (-2, 0), (-1, 1)]:
        found = hidden_motion(system, meeting, *window)
        assert found.gains == pytest.approx(moved(text, *window).gains, rel=1e-8)


def test_a_double_multiplier_on_the_unit_circle_is_neutral_within_an_error_like_the_root_of_rounding():
    found = moved(hidden([["0", "1"], ["0", "0"]]), 0, 100, period=True)
    assert [one.kind for one in found.floquet] == ["neutral", "neutral"]
    assert all(abs(one.multiplier - 1) <= one.error < 1e-3 for one in found.floquet)


def test_the_multipliers_of_a_window_that_is_no_period_are_not_given():
    assert moved(hidden(WU), 0, 1).multipliers == ()


@pytest.mark.parametrize(("a", "gamma"), [("-0.01", 0.367879), ("0", 1.0), ("0.01", 2.718282)])
def test_the_factor_of_the_single_channel_over_100_seconds_is_that_of_its_mode(a, gamma):
    """Kortunov & Proskura 2006, both rates equal: exp(100 a), whatever else the channel does."""
    system = read_text(
        f"parameters: {{g: 9.8, a: {a}}}\nstates: [alpha, V, R, dOm, dW]\n"
        "dynamics: {alpha: dOm, V: g*alpha + dW, R: V, dOm: a*dOm, dW: a*dW}\n"
        "measurements: {velocity: V, position: R}\n",
        "channel.yaml",
    ).systems[0]
    special = at_nominal(system).system()
    directions = analyze(special, Options(critical=False, certificate=False)).unobservable
    assert hidden_motion(special, directions, 0, 100).gains == pytest.approx([gamma], abs=5e-7)
