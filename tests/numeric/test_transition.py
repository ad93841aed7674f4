"""Φ(a, b), put together from panels, is the transition matrix: x(a) = Φ(a, b) x(b)."""

from itertools import pairwise

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import factorial

from obscli.numeric.errors import NotComputableError, TooManyStepsError
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.settings import Effort
from obscli.numeric.transition import edges_of, panels


EPS = np.finfo(float).eps

VARYING = """
states: [a, b, c, d]
A: [["cos(t)", 1, 0, "t/5"], [-1, "-1/(1 + t)", "exp(-t)", 0], [0, "sin(3*t)", 0.3, 1], [0, 0, 0, 0]]
H: [[1, 0, 0, 0]]
"""


def constant(A):
    n = len(A)
    rows = ", ".join("[" + ", ".join(map(repr, map(float, row))) + "]" for row in A)
    return f"states: [{', '.join(f'x{k}' for k in range(1, n + 1))}]\nA: [{rows}]\nH: [{[1] * n}]\n"


matrices = st.integers(1, 6).flatmap(
    lambda n: st.lists(st.integers(-20, 20), min_size=n * n, max_size=n * n).map(
        lambda v: np.array(v).reshape(n, n) / 16
    )
)


def exponential(A, T):
    """e^(A T) in many digits: scipy's expm is off by 150 eps in some of these."""
    with mpmath.workdps(30):
        return np.array(mpmath.expm(mpmath.matrix(A) * T).tolist(), dtype=float)


@settings(max_examples=40, deadline=None)
@given(matrices, st.floats(0.1, 4))
def test_time_invariant_systems_are_exponentials(transition, A, T):
    found, _, _ = transition(constant(A), 0.0, T)
    # roundings are relative to sums of absolute values, of which there are some in each of a dozen panels
    assert (np.abs(found - exponential(-A, T)) <= 30 * EPS * exponential(np.abs(A), T)).all()


@pytest.mark.parametrize(
    ("A", "exact"),
    [
        ("-1/(1 + t)", lambda a, b: (1 + b) / (1 + a)),
        ("cos(t)", lambda a, b: mpmath.exp(mpmath.sin(a) - mpmath.sin(b))),
        ("-2*t", lambda a, b: mpmath.exp(b * b - a * a)),
        ("3/(1 + t^2)", lambda a, b: mpmath.exp(3 * (mpmath.atan(a) - mpmath.atan(b)))),
        ("0", lambda _a, _b: mpmath.mpf(1)),
    ],
)
@pytest.mark.parametrize("interval", [(0.0, 1.0), (0.5, 4.0), (2.0, 2.0625)])
def test_scalar_closed_forms(transition, A, exact, interval):
    found, _, _ = transition(f"states: [x]\nA: [['{A}']]\nH: [[1]]\n", *interval)
    with mpmath.workdps(30):
        expected = float(exact(*map(mpmath.mpf, interval)))
    # a dozen panels, each wrong by an eps or two of max(1, Φ), carried to the end
    assert abs(found[0, 0] - expected) <= 40 * EPS * max(1.0, expected)


@pytest.mark.parametrize("points", [(0.0, 0.7, 2.0), (1.0, 1.1, 4.0), (0.0, 5.0, 6.0)])
def test_semigroup(transition, points):
    a, b, c = points
    whole, first, second = (transition(VARYING, *pair)[0] for pair in ((a, c), (a, b), (b, c)))
    assert np.abs(whole - first @ second).max() <= 100 * EPS * np.abs(first).max() * np.abs(second).max()


@pytest.mark.parametrize("interval", [(0.0, 1.0), (0.3, 5.0)])
def test_the_determinant_is_the_exponential_of_the_trace(transition, interval):
    a, b = interval
    found, _, _ = transition(VARYING, a, b)
    trace = np.sin(b) - np.sin(a) - np.log((1 + b) / (1 + a)) + 0.3 * (b - a)
    # a determinant loses what the matrix's condition allows
    assert np.linalg.det(found) == pytest.approx(np.exp(-trace), rel=100 * EPS * np.linalg.cond(found))


def test_constant_states_pass_unchanged(transition):
    found, _, _ = transition(VARYING, 0.0, 3.0)
    np.testing.assert_array_equal(found[3], [0, 0, 0, 1])


FAST = ["exp(sin(20*t))", "exp(sin(20*t))*cos(7*t)", "1/(1/50 + (t - 1)^2)", "tanh(30*(t - 1))"]


@pytest.mark.parametrize("A", FAST)
def test_panels_are_halved_where_coefficients_need_it(transition, A):
    found, _, ends = transition(f"states: [x]\nA: [['{A}']]\nH: [[1]]\n", 0.0, 2.0, longest=2.0)
    f = {"exp": mpmath.exp, "sin": mpmath.sin, "cos": mpmath.cos, "tanh": mpmath.tanh}

    def integrand(t):
        return eval(A.replace("^", "**"), {"__builtins__": {}}, {**f, "t": t})

    with mpmath.workdps(25):
        exact = mpmath.exp(-mpmath.quad(integrand, mpmath.linspace(0, 2, 101)))
    assert len(ends) > 4
    assert (np.diff(ends) > 0).all()
    assert ends[-1] == 2
    # the tolerance of the steps is relative to an entry's size on its panel, and errors of panels add
    assert abs(found[0, 0] / float(exact) - 1) < 1e-14 * len(ends) * 5


def test_what_cannot_be_resolved_is_named_with_its_instant(transition):
    with pytest.raises(NotComputableError, match=r"cannot be resolved near t = 0\.33333.*--from"):
        transition("states: [x]\nA: [['1/(t - 1/3)']]\nH: [[1]]\n", 0.0, 1.0)


def test_too_many_steps(transition):
    text = "states: [x]\nA: [['cos(100*t)']]\nH: [[1]]\n"
    with pytest.raises(TooManyStepsError, match="more than 20 steps would be needed"):
        transition(text, 0.0, 10.0, most_steps=20)
    transition(text, 0.0, 0.1, most_steps=20)


def test_steps_of_a_time_invariant_system_count_too(system):
    """Each costs a factorisation, though alike panels are solved once."""
    given = NumericSystem(system("states: [x]\nA: [[-1]]\nH: [[1]]\n"), 0.0, 100.0)
    with pytest.raises(TooManyStepsError):
        list(panels(given, np.linspace(0, 100, 101), Effort(1e-14, 20)))


OSCILLATORS = constant(np.array([[0, 3, 0, 1], [-3, -0.1, 2, 0], [0, 0, 0, 5], [0, 0, -5, 0]]))


@pytest.mark.parametrize("longest", [0.1, 1.0, 8.0])
def test_a_time_invariant_system_solved_once_is_the_same_as_one_by_one(system, longest):
    """Panels of 8 are halved, so they come in parts; lengths agree to rounding only."""
    given = NumericSystem(system(OSCILLATORS), 0.0, 20.0)
    edges = edges_of(0.0, np.array([0.5, 4.5, 12.5, 20.0]), longest, 10_000)
    effort = Effort(1e-14, 10_000)
    (together,) = panels(given, edges, effort)
    alone = [p for a, b in pairwise(edges) for p in panels(given, np.array([a, b]), effort)]
    np.testing.assert_allclose(together.ends, np.concatenate([p.ends for p in alone]), rtol=4 * EPS)
    for part in ("transition", "rows"):
        expected = np.concatenate([getattr(p, part) for p in alone])
        # edges are rounded to eps of 20, panels are as short as 0.1
        np.testing.assert_allclose(getattr(together, part), expected, atol=1e-14 + 20 * EPS / longest)


def test_edges_hold_every_instant_and_are_no_longer_than_allowed():
    instants = np.array([0.3, 0.31, 2.0, 7.0])
    edges = edges_of(0.1, instants, 0.5, 100)
    assert set(instants) <= set(edges)
    assert edges[0] == 0.1
    assert (np.diff(edges) > 0).all()
    assert np.diff(edges).max() <= 0.5 * (1 + 1e-9)
    assert len(edges) == 1 + 1 + 1 + 4 + 10


@pytest.mark.parametrize("s_m", [1, 2])
def test_rows_are_the_roots_of_the_gramian_of_a_panel(system, s_m):
    """x' = a x, y = (1, 2)ᵀ x: the rows' squares add up to |H|² (1 − e^(−2ah))/(2a)."""
    H = [[1], [2]][:s_m]
    given = NumericSystem(system(f"states: [x]\nA: [[0.5]]\nH: {H}\n"), 0.0, 1.0)
    (found,) = panels(given, np.array([0.0, 0.75]), Effort(1e-14, 100))
    expected = np.sum(np.square(H)) * (1 - np.exp(-0.75)) / 1
    assert (found.rows[0, :, 0] ** 2).sum() == pytest.approx(expected, rel=20 * EPS)


@pytest.mark.parametrize(("start", "stop"), [(0.0, 20.0), (-1.0, 0.3)])
def test_a_strongly_coupled_chain_is_a_polynomial_and_solved_once_a_length(system, monkeypatch, start, stop):
    """Halved until its entries, (c (a − b))^k/k!, are resolved: one panel of every length is solved."""
    n, c = 40, 100
    given = NumericSystem(system(constant(c * np.eye(n, k=1))), start, stop)
    seen = []
    matrices = NumericSystem.coefficients
    monkeypatch.setattr(NumericSystem, "coefficients", lambda s, t: seen.append(len(t)) or matrices(s, t))
    (found,) = panels(given, np.array([start, stop]), Effort(1e-14, 20_000))
    whole = np.eye(n)
    for rows in found.transition:
        phi = np.eye(n)
        phi[given.moving] = rows
        whole = whole @ phi
    power = np.arange(n) - np.arange(n)[:, None]
    x = -c * (stop - start)
    exact = np.where(power < 0, 0, x ** np.abs(power) / factorial(np.abs(power)))
    np.testing.assert_allclose(whole, exact, rtol=1e-11)
    assert found.ends[-1] == stop
    assert len(found.ends) >= 64
    assert sum(seen) <= seen[0] * (2 + np.log2(len(found.ends)))
