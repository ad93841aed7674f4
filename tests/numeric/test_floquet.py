"""The Floquet–Lyapunov reduction: systems whose reduction is known in closed form, and laws that all obey."""

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import block_diag, expm

from obscli.numeric.errors import NotComputableError, UnfitRequestError
from obscli.numeric.finding import NotComputed
from obscli.numeric.floquet import _tried, floquet
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.periodic_steps import steps_between
from obscli.numeric.settings import Effort


J = np.array([[0.0, -1.0], [1.0, 0.0]])


def written(A, states=None):
    """A model text of a matrix of numbers or expressions, its first state measured."""
    states = states or [f"x{k + 1}" for k in range(len(A))]
    rows = ", ".join("[" + ", ".join(f"'{entry}'" for entry in row) + "]" for row in A)
    return f"states: [{', '.join(states)}]\nA: [{rows}]\nH: [{[1] + [0] * (len(A) - 1)}]\n"


def turning(B, omega):
    """A(t) of x = Rot(ω t) z, z' = B z: A = Rot B Rotᵀ + ω J."""
    c, s = f"cos({omega}*t)", f"sin({omega}*t)"
    (a, b), (d, e) = (map(repr, row) for row in B.tolist())
    return [
        [
            f"({a})*{c}^2 - ({b} + {d})*{c}*{s} + ({e})*{s}^2",
            f"({b})*{c}^2 + ({a} - ({e}))*{c}*{s} - ({d})*{s}^2 - {omega}",
        ],
        [
            f"({d})*{c}^2 + ({a} - ({e}))*{c}*{s} - ({b})*{s}^2 + {omega}",
            f"({e})*{c}^2 + ({b} + {d})*{c}*{s} + ({a})*{s}^2",
        ],
    ]


def exponential(B, T):
    with mpmath.workdps(30):
        return np.array(mpmath.expm(mpmath.matrix(B) * mpmath.mpf(T)).tolist(), dtype=float)


def random(n, seed):
    """A periodic matrix without structure."""
    source = np.random.default_rng(seed)

    def entry():
        a, b, c = np.round(source.normal(size=3), 3)
        return f"({a}) + ({b})*cos(t) + ({c})*sin(2*t)"

    return [[entry() for _ in range(n)] for _ in range(n)]


MARKUS_YAMABE = [
    ["-1 + 3/2*cos(t)^2", "1 - 3/2*sin(t)*cos(t)"],
    ["-1 - 3/2*sin(t)*cos(t)", "-1 + 3/2*sin(t)^2"],
]
WU = [
    ["-11/2 + 15/2*sin(12*t)", "15/2*cos(12*t)"],
    ["15/2*cos(12*t)", "-11/2 - 15/2*sin(12*t)"],
]
MATHIEU = [["0", "1"], ["-(1 + 3/10*cos(2*t))", "0"]]
CASES = [
    pytest.param(MARKUS_YAMABE, 2 * np.pi, id="Markus and Yamabe"),
    pytest.param(WU, np.pi / 6, id="Wu"),
    pytest.param(MATHIEU, np.pi, id="Mathieu"),
    pytest.param(random(3, 0), 2 * np.pi, id="three states"),
    pytest.param(random(5, 2), 2 * np.pi, id="five states"),
    pytest.param([["cos(t)", "1"], ["sin(t)", "-60"]], 2 * np.pi, id="far apart"),
    pytest.param([["0", "1", "sin(t)"], ["0", "0", "1"], ["0", "0", "0"]], 2 * np.pi, id="defective"),
]


@pytest.fixture(scope="module")
def reduced(system):
    """The reduction of a matrix from 0.3 on, each found once."""
    found = {}

    def one(A, period):
        key = (repr(A), period)
        if key not in found:
            found[key] = floquet(system(written(A)), 0.3, period, samples=8)
        return found[key]

    return one


@pytest.mark.parametrize(("A", "period"), CASES)
class TestLaws:
    def test_the_equivalent_reproduces_the_monodromy_matrix(self, reduced, A, period):
        found = reduced(A, period)
        R, M = found.equivalent.R, found.monodromy
        turns = 2 if found.equivalent.doubled else 1
        error = np.linalg.norm(expm(turns * period * R) - np.linalg.matrix_power(M, turns))
        assert error < 1e-10 * np.linalg.norm(M) ** turns

    def test_the_periodic_factor_begins_with_the_identity_and_returns(self, reduced, A, period):
        found = reduced(A, period).equivalent
        assert len(found.P) == len(found.instants) == (17 if found.doubled else 9)
        np.testing.assert_allclose(found.P[0], np.eye(len(A)), atol=1e-12)
        np.testing.assert_allclose(found.P[-1], np.eye(len(A)), atol=1e-10)
        assert found.residual < 1e-11

    def test_multipliers_and_trace_obey_liouville(self, reduced, A, period):
        """det M = e^(∫ tr A) = e^(T tr R)."""
        found = reduced(A, period)
        t = 0.3 + period * np.arange(64) / 64
        entries = {"cos": np.cos, "sin": np.sin, "t": t}
        trace = sum(
            np.mean(eval(A[k][k].replace("^", "**"), {"__builtins__": {}}, entries)) for k in range(len(A))
        )
        assert sum(one.real for one in found.exponents) == pytest.approx(trace, abs=1e-10)
        assert np.trace(found.equivalent.R) == pytest.approx(trace, abs=1e-10)

    def test_the_exponents_are_the_eigenvalues_of_the_equivalent(self, reduced, A, period):
        found = reduced(A, period)
        left = list(np.linalg.eigvals(found.equivalent.R))
        for one, mode in zip(found.exponents, found.modes, strict=True):
            # imaginary parts up to 2π/T, or π/T where P has two periods: compare powers of multipliers
            apart = [abs(np.exp(2 * period * (other - one)) - 1) for other in left]
            k = int(np.argmin(apart))
            assert apart[k] < 1e-8 + 4 * mode.error + 4 * period * np.finfo(float).eps ** (1 / len(A))
            del left[k]

    def test_multipliers_do_not_depend_on_where_the_period_starts(self, system, reduced, A, period):
        first, second = reduced(A, period), floquet(system(written(A)), 1.1, period, samples=8)
        for a, b in zip(first.modes, second.modes, strict=True):
            assert abs(a.multiplier - b.multiplier) <= 2 * (a.error + b.error) * abs(a.multiplier)


@pytest.mark.parametrize("seed", range(6))
def test_in_turning_axes_the_equivalent_and_its_factor_are_known(system, seed):
    """x = Rot(ω t) z, z' = B z: R = B and P = Rot, as long as B turns by less than half a period."""
    B = np.round(np.random.default_rng(seed).normal(size=(2, 2)), 2)
    omega = 4
    found = floquet(system(written(turning(B, omega))), 0.0, 2 * np.pi / omega)
    assert (np.abs(found.equivalent.R - B) <= found.equivalent.R_error).all()
    assert not found.equivalent.doubled
    expected = [expm(omega * t * J) for t in found.equivalent.instants]
    np.testing.assert_allclose(found.equivalent.P, expected, atol=1e-12)
    np.testing.assert_allclose(found.equivalent.outputs, np.array(expected)[:, :1], atol=1e-12)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("omega", [1, 4, 30])
def test_the_error_of_the_monodromy_matrix_is_a_bound(system, seed, omega):
    B = np.round(np.random.default_rng(seed).normal(size=(2, 2)), 2)
    found = floquet(system(written(turning(B, omega))), 0.0, 2 * np.pi / omega)
    exact = exponential(B, 2 * np.pi / omega)
    assert (np.abs(found.monodromy - exact) <= found.monodromy_error).all()
    assert (found.monodromy_error <= 1e-11 * np.linalg.norm(exact)).all()
    values = np.linalg.eigvals(B)
    for one in found.modes:
        assert min(abs(one.multiplier / np.exp(values * 2 * np.pi / omega) - 1)) <= one.error


@pytest.mark.parametrize("seed", range(4))
def test_a_constant_system_is_its_own_equivalent(system, seed):
    A = np.round(np.random.default_rng(seed).normal(size=(4, 4)), 2)
    found = floquet(system(written(A)), 2.0, 0.5)
    assert (np.abs(found.equivalent.R - A) <= found.equivalent.R_error).all()
    np.testing.assert_allclose(found.equivalent.P, np.broadcast_to(np.eye(4), (33, 4, 4)), atol=1e-11)


@pytest.mark.parametrize(
    ("path", "period", "multipliers", "doubled"),
    [
        ("markus_yamabe", 2 * np.pi, [np.exp(np.pi), np.exp(-2 * np.pi), np.exp(-2 * np.pi)], False),
        ("wu", np.pi / 6, [np.exp(-np.pi / 6), -np.exp(-np.pi / 6), -np.exp(-10 * np.pi / 6)], True),
    ],
)
def test_the_bundled_counterexamples(bundled, path, period, multipliers, doubled):
    found = floquet(bundled(f"textbook/{path}.yaml"), 0.0, period)
    assert sorted(found.multipliers, key=lambda z: z.real) == pytest.approx(sorted(multipliers), rel=1e-10)
    assert found.equivalent.doubled is doubled


def test_mathieu_against_another_integrator(system):
    found = floquet(system(written(MATHIEU)), 0.0, np.pi, samples=4)

    def slope(t, x):
        return [x[1], -(1 + 0.3 * np.cos(2 * t)) * x[0]]

    others = [
        solve_ivp(slope, (0, 2 * np.pi), x, "DOP853", found.equivalent.instants, rtol=1e-12, atol=1e-13).y
        for x in np.eye(2)
    ]
    R = found.equivalent.R
    for k, t in enumerate(found.equivalent.instants):
        phi = np.array([one[:, k] for one in others]).T
        np.testing.assert_allclose(found.equivalent.P[k] @ expm(R * t), phi, atol=1e-9)
    np.testing.assert_allclose(found.monodromy, np.array([one[:, 4] for one in others]).T, atol=1e-9)


def test_what_decays_beyond_all_digits_is_as_accurate_as_what_grows(system):
    """Of a triangular system, the exponents are the means of the diagonal: from e^126 to e^-377."""
    found = floquet(system(written([["20 + cos(t)", "1"], ["0", "-60 + 2*sin(t)"]])), 0.0, 2 * np.pi)
    assert [one.real for one in found.exponents] == pytest.approx([20, -60], rel=1e-13)
    R = found.equivalent.R
    assert np.diag(R) == pytest.approx([20, -60], rel=1e-12)
    assert abs(R[1, 0]) <= found.equivalent.R_error[1, 0]
    assert found.equivalent.residual < 1e-12


def test_the_units_of_the_states_do_not_matter(system):
    """With x = D x̃ the equivalent is D⁻¹ R D, and so are P and M."""
    D, A = np.array([1.0, 1e6]), random(2, 5)
    plain = floquet(system(written(A)), 0.0, 2 * np.pi)
    other = [[f"({one})*{D[j]:.0f}/{D[i]:.0f}" for j, one in enumerate(row)] for i, row in enumerate(A)]
    sizes = "states: {x1: {scale: 1}, x2: {scale: 1/1000000}}"
    scaled = floquet(system(written(other).replace("states: [x1, x2]", sizes)), 0.0, 2 * np.pi)
    ratio = D / D[:, None]
    np.testing.assert_allclose(scaled.equivalent.R, plain.equivalent.R * ratio, rtol=1e-11)
    np.testing.assert_allclose(scaled.monodromy, plain.monodromy * ratio, rtol=1e-11)
    assert scaled.equivalent.condition == pytest.approx(plain.equivalent.condition, rel=1e-9)


def test_far_from_zero_the_errors_know_how_instants_are_rounded(system):
    """Beside 1e7 instants are 2e-9 apart: so much may the period be off."""
    B = np.array([[-1.0, 2.0], [-2.0, 0.5]])
    found = floquet(system(written(B)), 1e7, 0.7)
    assert (np.abs(found.monodromy - exponential(B, 0.7)) <= found.monodromy_error).all()
    assert (found.monodromy_error < 1e-7).all()
    assert (np.abs(found.equivalent.R - B) <= found.equivalent.R_error).all()


def test_states_of_unlike_size_need_no_scale(system):
    """An oscillator of 100 rad/s, its position in metres, as accurate as in units that balance it."""
    unlike = floquet(system(written([["0", "1"], ["-10000*(1 + cos(t)/2)", "0"]])), 0.0, 2 * np.pi)
    alike = floquet(system(written([["0", "100"], ["-100*(1 + cos(t)/2)", "0"]])), 0.0, 2 * np.pi)
    assert unlike.equivalent.condition < 2 * alike.equivalent.condition
    D = np.array([1.0, 100.0])
    np.testing.assert_allclose(unlike.monodromy, alike.monodromy * D[:, None] / D, rtol=1e-9)
    assert max(one.error for one in unlike.modes) < 10 * max(one.error for one in alike.modes)


def test_constant_states_stay_themselves(system):
    A = [["sin(t) - 1", "cos(t)", "1"], ["0", "0", "0"], ["0", "0", "0"]]
    found = floquet(system(written(A)), 0, 2 * np.pi)
    assert (found.equivalent.R_error[1:] == 0).all()
    np.testing.assert_array_equal(found.equivalent.R[1:], 0)
    np.testing.assert_array_equal(found.equivalent.P[:, 1:], np.broadcast_to(np.eye(3)[1:], (33, 2, 3)))


def test_a_system_at_rest_has_nothing_to_reduce(system):
    found = floquet(system(written([["0", "0"], ["0", "0"]])), 0.0, 1.0)
    np.testing.assert_array_equal(found.monodromy, np.eye(2))
    np.testing.assert_array_equal(found.equivalent.R, 0)


def test_multipliers_of_minus_one_make_two_periods_of_one(system):
    found = floquet(system(written(J / 2)), 0.0, 2 * np.pi)
    assert found.multipliers == pytest.approx([-1, -1])
    assert found.equivalent.doubled
    assert found.equivalent.instants[-1] == pytest.approx(4 * np.pi)


def test_where_neither_one_nor_two_periods_have_a_logarithm_that_is_said(system):
    """Quarter and half turns of the same modulus: M has −1, and M² has it too."""
    found = floquet(system(written(block_diag(J / 2, J / 4))), 0.0, 2 * np.pi)
    assert isinstance(found.equivalent, NotComputed)
    assert "negative real axis" in found.equivalent.reason
    assert sorted(abs(one) for one in found.multipliers) == pytest.approx([1, 1, 1, 1])


@pytest.mark.parametrize("wrong", [1e-9, 1e-6, 1e-3])
def test_the_residual_sees_a_wrong_equivalent_and_a_wrong_factor(system, wrong):
    """z' = (R + δ) z fails on the next period by about δ T over the samples, P + δ by about δ."""
    numeric = NumericSystem(system(written(MATHIEU)), 0.0, 2 * np.pi)
    found = floquet(numeric.system, 0.0, np.pi, samples=4).equivalent
    period = found.instants[:5]
    other = steps_between(numeric, period + np.pi, 0.5, Effort(1e-13, 1000), np.ones(2))
    assert _tried(found.P, found.R, period, other) < 1e-13
    assert wrong / 10 < _tried(found.P, found.R + wrong * J, period, other) < 10 * wrong
    bent = found.P.copy()
    bent[2] = bent[2] @ (np.eye(2) + wrong * np.array([[0, 1], [0, 0]]))
    assert wrong / 10 < _tried(bent, found.R, period, other) < 10 * wrong


def test_growth_beyond_all_numbers_is_named(system):
    with pytest.raises(NotComputableError, match="beyond the largest number within a period"):
        floquet(system(written([["200 + sin(t)"]])), 0.0, 2 * np.pi)


@pytest.mark.parametrize(
    ("A", "period", "samples", "words"),
    [
        (
            "sin(t)",
            3.0,
            8,
            r"does not repeat itself after 3: it differs between t = .* give a period of A\(t\)",
        ),
        ("t", 1.0, 8, "does not repeat itself"),
        ("sin(t)", 2 * np.pi, 1, "at least 2 intervals, not 1"),
        ("sin(t)", -1.0, 8, "a positive number of units of time, not -1"),
        ("sin(t)", np.inf, 8, "a positive number of units of time, not inf"),
    ],
)
def test_what_does_not_fit_is_refused(system, A, period, samples, words):
    with pytest.raises(UnfitRequestError, match=words):
        floquet(system(written([[A]])), 0.0, period, samples)
