"""Local observability in windows: identities of the values, closed forms, three flights of a guided rocket."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from obscli.numeric.errors import UnfitRequestError
from obscli.numeric.gramian import Gramian
from obscli.numeric.local_stack import frozen_stack
from obscli.numeric.local_windows import (
    WindowSettings,
    sampled,
    sampling_of,
    stack_at,
    values_of,
    window_series,
)
from obscli.numeric.matrix_exponential import exponentials
from obscli.numeric.numeric_system import Coefficients, NumericSystem
from obscli.numeric.subspace import subspaces
from obscli.numeric.window_measures import joined, window_values
from obscli.numeric.window_scaling import WindowScaling, window_scaling


_spec = importlib.util.spec_from_file_location("flights", Path(__file__).with_name("flights.py"))
flown = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(flown)
CASES, MOVING, NOISE, PRIOR, Flight = flown.CASES, flown.MOVING, flown.NOISE, flown.PRIOR, flown.Flight

RAW = WindowScaling(np.ones(15), "none", None, None, (), (), asked=True)
SCALED = WindowScaling(PRIOR, "prior", np.diag(1 / NOISE), np.diag(PRIOR), (), (), asked=False)

MOVED = """
states: [a, b, c, d]
A: [[0, 1 + t/10, 0, 0], [-1, 0, sin(2*t), 0], [0, 0, 0, 0], [0, 0, 0, 0]]
H: [[1, 0, 0, cos(t)], [0, 0, 1, 1]]
"""
NOISY = MOVED + "noise: {R: [0.01, 0.02], step: 0.1, P0_std: [1, 1, 2, 2]}\n"


def of_matrix(R, weights="squared", forms=None):
    """The values of one matrix, its units and its noise 1."""
    R = np.atleast_2d(R)
    n = R.shape[1]
    root = np.zeros((1, n, n))
    T = np.linalg.qr(R, mode="r")
    root[0, : len(T)] = T
    error = 1e-30 * np.linalg.norm(R) ** 2 * np.eye(n)[None]
    gramian = Gramian("square-root", np.zeros(1), np.zeros(1), root, np.ones((1, n)), error, np.zeros(1))
    forms = np.eye(n)[None] if forms is None else forms
    return window_values(subspaces(gramian), forms, weights, (root, np.eye(n)))


def along(flight, form="discrete", scaling=SCALED, samples=15, h=0.1, earth=True, **changed):
    """The values along a flight: states, then roll, pitch, azimuth."""
    step = 1.0 if form == "continuous" else h
    stack = frozen_stack(flight.coefficients(earth=earth, **changed), MOVING, form, samples, step)
    forms = np.concatenate([np.tile(np.eye(15), (len(flight.t), 1, 1)), flight.forms()], axis=1)
    return values_of(stack, forms, flight.t, WindowSettings(samples * h, h, form), scaling)


def angles(values):
    """Roll, pitch, azimuth, (k, 3)."""
    return values.equivalent[:, 15:]


@pytest.fixture(scope="module")
def flights():
    return {case: Flight(case) for case in CASES}


@pytest.fixture(scope="module")
def random_matrices():
    rng = np.random.default_rng(8)
    return [rng.normal(size=(m, n)) for m, n in [(4, 4), (9, 5), (3, 6), (7, 7)]]


# --- identities ------------------------------------------------------------------------------------------------


def test_the_index_is_the_diagonal_of_the_root_of_the_gram_matrix(random_matrices):
    for R in random_matrices:
        found = of_matrix(R)
        size, vectors = np.linalg.eigh(R.T @ R)
        root = (vectors * np.sqrt(np.maximum(size, 0))) @ vectors.T
        np.testing.assert_allclose(found.equivalent[0], np.diag(root), rtol=1e-7)
        sizes = np.linalg.svd(R, compute_uv=False)
        assert abs(found.equivalent.sum() - sizes.sum()) < 1e-12 * sizes.sum()
        assert (found.equivalent <= found.column_norm * (1 + 1e-12)).all()
        np.testing.assert_allclose(found.column_norm[0], np.linalg.norm(R, axis=0), rtol=1e-12)


def test_the_index_follows_the_matrix(random_matrices):
    rng = np.random.default_rng(3)
    for R in random_matrices:
        m, n = R.shape
        given = of_matrix(R).equivalent
        Q = np.linalg.qr(rng.normal(size=(m, m)))[0]
        order = rng.permutation(n)
        np.testing.assert_allclose(of_matrix(Q @ R).equivalent, given, rtol=1e-12)
        np.testing.assert_allclose(of_matrix(3 * R).equivalent, 3 * given, rtol=1e-12)
        np.testing.assert_allclose(of_matrix(R[:, order]).equivalent, given[:, order], rtol=1e-12)
        others = np.eye(n)
        others[1:, 1:] = np.linalg.qr(rng.normal(size=(n - 1, n - 1)))[0]
        np.testing.assert_allclose(of_matrix(R @ others).equivalent[:, 0], given[:, 0], rtol=1e-12)


def test_a_diagonal_matrix_gives_its_entries():
    found = of_matrix(np.diag([3.0, -2.0, 0.5]))
    for values in (found.equivalent, found.column_norm, found.residual, found.conventional):
        np.testing.assert_allclose(values[0], [3, 2, 0.5], rtol=1e-14)
    np.testing.assert_allclose(found.posterior[0], 1 / np.sqrt([10, 5, 1.25]), rtol=1e-14)


def test_a_positive_index_of_what_is_not_identifiable():
    found = of_matrix([[1.0, 1.0]])
    np.testing.assert_allclose(found.equivalent[0], np.sqrt(0.5), rtol=1e-14)
    assert (found.residual == 0).all()
    sum_of_both = of_matrix([[1.0, 1.0]], forms=np.array([[[1.0, 1.0]]]))
    np.testing.assert_allclose(sum_of_both.residual, np.sqrt(2), rtol=1e-14)


def test_the_residual_index_is_the_distance_of_a_column_from_the_others(random_matrices):
    for R in random_matrices:
        n = R.shape[1]
        found = of_matrix(R)
        for k in range(n):
            others = np.delete(R, k, axis=1)
            rest = R[:, k] - others @ np.linalg.lstsq(others, R[:, k], rcond=None)[0]
            size = np.linalg.norm(rest)
            assert abs(found.residual[0, k] - (size if size > 1e-9 else 0)) < 1e-9


def test_the_posterior_ratio_is_that_of_the_information(random_matrices):
    for R in random_matrices:
        P = np.linalg.inv(np.eye(R.shape[1]) + R.T @ R)
        np.testing.assert_allclose(of_matrix(R).posterior[0], np.sqrt(np.diag(P)), rtol=1e-10)


def test_repeated_singular_values_are_seen_and_only_squares_do_not_mind():
    rng = np.random.default_rng(5)
    left, right = (np.linalg.qr(rng.normal(size=(4, 4)))[0] for _ in range(2))
    R = left @ np.diag([2.0, 2.0, 1.0, 0.3]) @ right
    assert of_matrix(R).degenerate.all()
    assert not of_matrix(left @ np.diag([2.0, 1.5, 1.0, 0.3]) @ right).degenerate.any()
    nudged = R + 1e-13 * rng.normal(size=(4, 4))
    np.testing.assert_allclose(of_matrix(nudged).equivalent, of_matrix(R).equivalent, rtol=1e-11)
    assert np.abs(of_matrix(nudged, "abs").equivalent - of_matrix(R, "abs").equivalent).max() > 1e-6


def test_a_state_without_a_singular_value_has_none():
    found = of_matrix([[1.0, 0.1, 0.0]])
    assert found.conventional[0, 0] == pytest.approx(np.hypot(1, 0.1))
    assert np.isnan(found.conventional[0, 1:]).all()


# --- stacks ----------------------------------------------------------------------------------------------------


def test_exponentials_are_the_exponentials():
    from scipy.linalg import expm

    rng = np.random.default_rng(1)
    for size in (1e-3, 1.0, 30.0):
        A = size * rng.normal(size=(5, 4, 4))
        found = exponentials(A, np.arange(4), 0.1)
        expected = expm(0.1 * A)
        assert np.abs(found - expected).max() < 1e-12 * np.abs(expected).max()


def test_units_far_apart_cost_nothing():
    A = np.array([[[0.0, 1e9, 0], [0, 0, 1e-9], [0, 0, 0]]])
    expected = np.eye(3) + A[0] + A[0] @ A[0] / 2
    np.testing.assert_allclose(exponentials(A, np.arange(3), 1.0)[0], expected, rtol=1e-15)


def test_only_moving_rows_are_kept():
    A = np.array([[[0.0, 1, 2], [0, -1, 1]]])
    whole = exponentials(np.concatenate([A, np.zeros((1, 1, 3))], axis=1), np.arange(3), 0.3)
    np.testing.assert_allclose(exponentials(A, np.array([0, 1]), 0.3)[0], whole[0, :2], rtol=1e-14)


def numeric_of(system, text, stop=10.0):
    return NumericSystem(system(text), 0.0, stop)


def test_a_constant_system_is_the_same_frozen_and_true(system):
    text = "states: [a, b]\nA: [[0, 1], [-4, -0.1]]\nH: [[1, 0]]\n"
    numeric, t = numeric_of(system, text), np.array([0.0, 2.0])
    stacks = []
    for frozen in (True, False):
        settings = WindowSettings(1.0, 0.1, frozen=frozen)
        stacks.append(stack_at(numeric, sampling_of(numeric, settings, 0.0, 10.0), settings, t).rows)
    np.testing.assert_allclose(stacks[0], stacks[1], atol=1e-11)


def test_true_windows_follow_the_solution(system, transition):
    numeric, t = numeric_of(system, MOVED), np.array([0.5, 3.0])
    settings = WindowSettings(0.8, 0.2, frozen=False)
    found = stack_at(numeric, sampling_of(numeric, settings, 0.0, 10.0), settings, t).rows
    for i, start in enumerate(t):
        for j in range(1, 4):
            instant = start + 0.2 * j
            backward = transition(MOVED, start, instant)[0]  # Φ(start, instant)
            expected = numeric.matrices(np.array([instant]))[1][0] @ np.linalg.inv(backward)
            np.testing.assert_allclose(found[i, j], expected, atol=1e-10)


def test_windows_of_different_distances_share_their_steps(system):
    numeric = numeric_of(system, NOISY)
    values = {}
    for step in (0.1, 0.03):  # with 0.03 no two windows share a sample but every tenth
        settings = WindowSettings(0.5, step, frozen=False)
        sampling = sampling_of(numeric, settings, 0.0, 3.0)
        assert sampling.h == pytest.approx(0.1)
        scaling = window_scaling(numeric, None, sampling.h)
        values[step] = joined(list(window_series(numeric, sampling, settings, scaling)))
    coarse, fine = values[0.1], values[0.03]
    np.testing.assert_allclose(coarse.posterior[::3][:9], fine.posterior[::10][:9], rtol=1e-8)


def test_portions_do_not_change_the_values(system, monkeypatch):
    from obscli.numeric import local_windows

    numeric, settings = numeric_of(system, NOISY), WindowSettings(0.5, 0.1)
    sampling = sampling_of(numeric, settings, 0.0, 10.0)
    scaling = window_scaling(numeric, None, sampling.h)
    whole = list(window_series(numeric, sampling, settings, scaling))
    monkeypatch.setattr(local_windows, "_CHUNK", 400)
    parts = list(window_series(numeric, sampling, settings, scaling))
    assert len(whole) == 1 < len(parts)
    assert len(joined(parts).t) == sampling.windows
    np.testing.assert_allclose(joined(parts).equivalent, whole[0].equivalent, rtol=1e-13)


def test_outputs_are_sampled_by_their_rate_and_not_in_outages(system):
    text = MOVED.replace("H: [[1, 0, 0, cos(t)], [0, 0, 1, 1]]", "measurements: {y: a + cos(t)*d, z: c + d}")
    text = text + "outputs: {y: {every: 0.1}, z: {every: 0.25, during: [[0, 0.4]]}}\n"
    numeric, settings = numeric_of(system, text), WindowSettings(0.6)
    sampling = sampling_of(numeric, settings, 0.0, 10.0)
    assert (sampling.h, sampling.step, sampling.samples) == pytest.approx((0.1, 0.1, 6))
    flags = sampled(numeric, np.array([0.0, 0.2]), sampling)
    assert flags[:, :, 0].all()
    assert flags[0, :, 1].tolist() == [True, False, False, True, False, False]
    assert flags[1, :, 1].tolist() == [True, False, False, False, False, False]


def test_units_of_states_and_noise_are_those_of_the_file(system):
    numeric = numeric_of(system, NOISY)
    scaling = window_scaling(numeric, None, 0.1)
    assert scaling.origin == "prior"
    assert scaling.is_of_prior
    np.testing.assert_allclose(scaling.units, [1, 1, 2, 2], rtol=1e-14)
    np.testing.assert_allclose(scaling.whitening, np.diag([10, 50**0.5]), rtol=1e-14)
    bare = window_scaling(numeric_of(system, MOVED), None, 0.1)
    assert (bare.origin, bare.weights, bare.without_prior) == ("none", None, ("a", "b", "c", "d"))


def test_the_posterior_is_that_of_the_prior_whatever_the_units(system):
    correlated = NOISY.replace(
        "P0_std: [1, 1, 2, 2]", "P0: [[1, 0.5, 0, 0], [0.5, 1, 0, 0], [0, 0, 4, 0], [0, 0, 0, 4]]"
    )
    numeric, settings = numeric_of(system, correlated), WindowSettings(0.5, 0.1)
    sampling = sampling_of(numeric, settings, 0.0, 2.0)
    stack = stack_at(numeric, sampling, settings, sampling.starts(0, 1)).rows[0]
    rows = stack.reshape(-1, 4) / np.tile([0.1, 0.02**0.5], len(stack))[:, None]
    P0 = np.array([[1, 0.5, 0, 0], [0.5, 1, 0, 0], [0, 0, 4, 0], [0, 0, 0, 4]])
    P = np.linalg.inv(np.linalg.inv(P0) + rows.T @ rows)
    for asked in (None, "none"):
        scaling = window_scaling(numeric, asked, sampling.h)
        found = next(window_series(numeric, sampling, settings, scaling))
        np.testing.assert_allclose(found.posterior[0], np.sqrt(np.diag(P) / np.diag(P0)), rtol=1e-10)


@pytest.mark.parametrize(
    ("length", "step", "words"),
    [
        (20, 0.1, "does not fit"),
        (1, None, "nothing says how often"),
        (0.05, 0.1, "no two samples"),
        (1, -1, "--step"),
        (1, 1e-300, "1e-300 makes 1e\\+300 samples of each window; 100000 at the most"),
        (1e300, 0.1, "does not fit"),
        (0.01, 2e-7, "a step of 2e-07 makes 5e\\+07 windows; 20000000 at the most"),
    ],
)
def test_windows_that_cannot_be(system, length, step, words):
    numeric = numeric_of(system, MOVED)
    with pytest.raises(UnfitRequestError, match=words):
        sampling_of(numeric, WindowSettings(length, step), 0.0, 10.0)


def test_the_last_window_still_fits(system):
    numeric = numeric_of(system, MOVED)
    assert sampling_of(numeric, WindowSettings(1.5, 0.1), 0.0, 3.0).windows == 17


# --- three flights ---------------------------------------------------------------------------------------------

#: Case, instant: roll, pitch, azimuth of the derivatives, of samples, of samples scaled; four digits each.
TABLE = {
    ("uncontrolled", 5.1): [(0, 28.3938, 18.8571), (0, 66.7536, 44.3388), (3e-5, 54.1528, 35.9705)],
    ("uncontrolled", 12.0): [(0, 15.2324, 10.9781), (0, 35.6117, 25.6684), (2e-5, 27.7005, 19.9667)],
    ("uncontrolled", 50.0): [(0, 2.4549, 2.4535), (0, 5.3463, 5.3435), (2e-6, 3.3182, 3.3164)],
    ("uncontrolled", 105.0): [(0, 13.4292, 6.2414), (0, 31.3380, 14.5637), (1e-5, 24.0757, 11.1883)],
    ("pitch", 12.0): [(18.4225, 26.9954, 24.2151), (43.3043, 63.4514, 56.9129), (35.0493, 51.3547, 46.0622)],
    ("pitch", 18.5): [(20.7608, 24.0646, 0.0678), (48.7589, 56.5195, 0.1589), (39.2290, 45.4732, 0.1278)],
    ("yaw", 12.0): [(18.4430, 8.6209, 24.1935), (43.3500, 20.2603, 56.8659), (35.0881, 16.3984, 46.0280)],
    ("yaw", 18.5): [(20.5957, 3.6624, 22.9692), (48.3728, 8.6031, 53.9495), (38.9299, 6.9240, 43.4187)],
}


@pytest.mark.parametrize(("place", "rows"), TABLE.items())
def test_the_table_of_values(flights, place, rows):
    flight = flights[place[0]].at([place[1]])
    for (form, scaling), expected in zip(
        [("continuous", RAW), ("discrete", RAW), ("discrete", SCALED)], rows, strict=True
    ):
        assert np.abs(angles(along(flight, form, scaling))[0] - expected).max() < 6e-5


def f_and_perpendicular(flight):
    """|f| and the squares of what is perpendicular to roll, pitch and azimuth axis."""
    f = flight.f
    theta = flight.data["pitch_deg"] * np.pi / 180
    x, y, z = f.T
    horizontal = (x * np.cos(theta) - y * np.sin(theta)) ** 2 + z**2
    return np.linalg.norm(f, axis=1), np.stack([y**2 + z**2, x**2 + y**2, horizontal], axis=1)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("samples", [3, 4, 15])
def test_the_closed_form_with_derivatives(flights, case, samples):
    flight = flights[case]
    size, squares = f_and_perpendicular(flight)
    expected = np.sqrt(2) * squares / np.sqrt(1 + size**2)[:, None]
    found = angles(along(flight, "continuous", RAW, samples))
    assert np.abs(found - expected).max() < 1e-5 * expected.max()
    plane = along(flight, "continuous", RAW, samples, earth=False).column_norm[:, 15:]
    np.testing.assert_allclose(plane, np.sqrt(2 * squares), rtol=1e-9, atol=1e-9)


def perpendicular_gain(size, scaled):
    """The index of an attitude error perpendicular to f: states p, v, phi, nabla, eps along one axis."""
    t, o = 0.1 * np.arange(15), np.zeros(15)
    v = np.stack([o, o + 1, size * t, t, size * t**2 / 2], axis=1)
    p = np.stack([o + 1, t, size * t**2 / 2, t**2 / 2, size * t**3 / 6], axis=1)
    if scaled:
        units = PRIOR[[6, 3, 0, 12, 9]]
        v, p = v * units / NOISE[0], p * units / NOISE[3]
    _, s, vt = np.linalg.svd(np.vstack([v, p]))
    return (vt[:, 2] ** 2 * s).sum()


def test_the_gain_across_the_specific_force():
    found = [perpendicular_gain(f, scaled=False) for f in (1, 2, 5, 10, 20, 50)]
    np.testing.assert_allclose(found, [2.0984, 5.5186, 15.9082, 32.8614, 66.4138, 166.619], rtol=3e-5)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("scaling", [RAW, SCALED])
def test_the_square_of_the_sine(flights, case, scaling):
    flight = flights[case]
    size, squares = f_and_perpendicular(flight)
    gain = np.array([perpendicular_gain(f, scaling is SCALED) for f in size])
    expected = squares / (size**2)[:, None] * gain[:, None]
    assert (np.abs(angles(along(flight, "discrete", scaling)) - expected) < 1e-3 * gain[:, None]).all()


def test_what_manoeuvres_do(flights):
    before, during = [5.5, 7.0, 9.0], [12.0, 14.0, 18.5, 20.0]
    for case in ("pitch", "yaw"):  # C1
        early, late = (angles(along(flights[case].at(t))) for t in (before, during))
        assert (early[:, 0] / early[:, 1] < 1e-4).all()
        assert (late[:, 0] / along(flights["uncontrolled"].at(during)).equivalent[:, 16] > 0.5).all()
        assert late[:, 0].min() / early[:, 0].max() > 1e4
    free = flights["uncontrolled"]
    found, fx = angles(along(free, "discrete", RAW)), np.abs(free.f[:, 0])
    line = np.polyfit(fx, found[:, 1], 1)
    rest = found[:, 1] - np.polyval(line, fx)
    assert 1 - rest.var() / found[:, 1].var() > 0.998  # C2
    by_size = found[np.argsort(fx), 1]
    assert (np.diff(by_size) > -2e-4 * by_size[1:]).all()  # up to the terms of the Earth's rate
    at_12 = {case: angles(along(flights[case].at([12.0])))[0] for case in CASES}
    assert 1.7 < at_12["pitch"][1] / at_12["uncontrolled"][1] < 1.9
    assert 2.1 < at_12["yaw"][2] / at_12["uncontrolled"][2] < 2.4  # C3
    cosine = np.cos(free.data["pitch_deg"] * np.pi / 180) ** 2
    assert np.abs(found[:, 2] / found[:, 1] - cosine).max() < 1e-3
    late = {case: angles(along(flights[case].at([19.0])))[0, 2] for case in ("pitch", "uncontrolled")}
    assert late["pitch"] < 0.02 * late["uncontrolled"]
    assert at_12["pitch"][2] > 2 * at_12["uncontrolled"][2]
    assert 0.5 < at_12["yaw"][1] / at_12["uncontrolled"][1] < 0.65  # C4


def test_no_attitude_error_is_identifiable_in_a_frozen_window_whatever_the_index(flights):
    at_12 = {}
    for case in CASES:
        found = along(flights[case])
        assert (found.rank == 12).all()
        assert found.decided.all()
        assert (found.residual[:, [0, 1, 2, 15, 16, 17]] == 0).all()
        assert (found.residual[:, 3:9] > 1).all()
        at_12[case] = along(flights[case].at([12.0])).posterior[0, 15:]
    np.testing.assert_allclose(at_12["uncontrolled"], [1.000, 0.121, 0.538], atol=6e-4)
    np.testing.assert_allclose(at_12["pitch"], [0.566, 0.069, 0.328], atol=6e-4)
    np.testing.assert_allclose(at_12["yaw"], [0.567, 0.826, 0.331], atol=6e-4)


def test_the_conventional_rule_fails_where_the_index_does_not(flights):
    flight = flights["yaw"].at([12.0])
    turned = np.zeros((1, 15, 15))
    turned[:] = np.eye(15)
    turned[:, :3, :3] = flight.C.transpose(0, 2, 1)  # attitude errors in quasi-body axes
    given = flight.coefficients()
    A = np.zeros((1, 15, 15))
    A[:, :9] = given.A
    back = turned.transpose(0, 2, 1)
    of_body = Coefficients((turned @ A @ back)[:, :9], given.H, given.A_error, given.H_error)
    stack = frozen_stack(of_body, MOVING, "continuous", 15, 1.0)
    found = values_of(stack, np.eye(15)[None], flight.t, WindowSettings(1.5, 0.1, "continuous"), RAW)
    np.testing.assert_allclose(found.equivalent[0, [0, 2]], [18.4430, 8.6209], atol=6e-5)
    assert found.degenerate.all()
    assert np.isnan(found.conventional[0, :3]).any()


# --- changed flights -------------------------------------------------------------------------------------------


def test_the_roll_angle_has_no_effect(flights):
    flight = flights["yaw"].at([12.0, 18.5])
    c, s = np.cos(0.7), np.sin(0.7)
    rolled = along(flight, C_b=np.array([[1, 0, 0], [0, c, -s], [0, s, c]]))
    np.testing.assert_allclose(angles(rolled), angles(along(flight)), rtol=1e-10)


def test_the_opposite_specific_force_has_no_effect(flights):
    flight = flights["pitch"].at([12.0, 18.5])
    np.testing.assert_allclose(angles(along(flight, f_sign=-1.0)), angles(along(flight)), rtol=1e-3)


def test_the_heading_has_no_effect_beyond_the_rate_of_the_earth(flights):
    flight = flights["yaw"].at([12.0, 18.5])
    given = angles(along(flight))
    flight.data["heading_deg_ccw_from_N"] = flight.data["heading_deg_ccw_from_N"] + 77
    np.testing.assert_allclose(angles(along(flight)), given, rtol=1e-3)


def permuted(found, order):
    """A's moving rows, H and the moving states with the states in another order."""
    A = np.zeros((len(found.A), 15, 15))
    A[:, :9] = found.A
    A = A[:, order][:, :, order]
    moving = np.flatnonzero(np.isin(order, MOVING))
    return Coefficients(A[:, moving], found.H[:, :, order], found.A_error, found.H_error), moving


def test_permuted_states_give_permuted_values(flights):
    flight = flights["pitch"].at([12.0])
    order = np.random.default_rng(2).permutation(15)
    found, moving = permuted(flight.coefficients(), order)
    scaling = WindowScaling(
        PRIOR[order], "prior", np.diag(1 / NOISE), np.diag(PRIOR[order]), (), (), asked=False
    )
    stack = frozen_stack(found, moving, "discrete", 15, 0.1)
    values = values_of(stack, np.eye(15)[None], flight.t, WindowSettings(1.5, 0.1), scaling)
    np.testing.assert_allclose(values.equivalent[0], along(flight).equivalent[0, order], rtol=1e-9)
    np.testing.assert_allclose(values.posterior[0], along(flight).posterior[0, order], rtol=1e-9)


def test_positions_in_radians_do_not_matter_to_attitude(flights):
    flight = flights["pitch"].at([12.0, 18.5])
    given = flight.coefficients()
    units = np.ones(15)
    units[6:8] = 6.4e6
    A, H = given.A * units / units[:9, None], given.H * units
    radians = Coefficients(A, H, given.A_error * units / units[:9, None], given.H_error)
    stack = frozen_stack(radians, MOVING, "continuous", 15, 1.0)
    values = values_of(stack, flight.forms(), flight.t, WindowSettings(1.5, 0.1), RAW)
    np.testing.assert_allclose(values.equivalent, angles(along(flight, "continuous", RAW)), rtol=1e-5)
    stack = frozen_stack(radians, MOVING, "discrete", 15, 0.1)
    prior = PRIOR / units
    scaling = WindowScaling(prior, "prior", np.diag(1 / NOISE), np.diag(prior), (), (), asked=False)
    values = values_of(stack, np.eye(15)[None].repeat(2, axis=0), flight.t, WindowSettings(1.5, 0.1), scaling)
    np.testing.assert_allclose(values.equivalent, along(flight).equivalent[:, :15], rtol=1e-9)


def test_the_bundled_model_has_the_matrices_of_the_theory(flights, bundled, monkeypatch):
    from obscli.numeric import numeric_system

    for case, t in (("pitch", 12.0), ("yaw", 50.0)):
        flight = flights[case].at([t])
        given = {key: float(one[0]) for key, one in flight.data.items()}
        degrees = np.pi / 180
        moved = dict(zip(("f_x", "f_y", "f_z"), flight.f[0], strict=True))
        moved |= dict(zip(("v_E", "v_N", "v_U"), (given["vE"], given["vN"], given["vU"]), strict=True))
        moved |= {"pitch": given["pitch_deg"] * degrees, "heading": given["heading_deg_ccw_from_N"] * degrees}
        moved["roll"] = 0.0

        class Held:
            rate, error, signals = 0.0, 0.0, None

            def __init__(self, *_args):
                pass

            def values(self, t, _orders, moved=moved):
                return {name: np.full(len(t), value) for name, value in moved.items()}

        monkeypatch.setattr(numeric_system, "Motion", Held)
        a, b = flight.radii()
        settings = {"lat": given["lat_deg"] * degrees, "r_m": float(a[0]), "r_n": float(b[0])}
        settings = {name: repr(value) for name, value in settings.items()}
        numeric = NumericSystem(bundled("rocket/ins_gnss_enu.yaml", "flight", settings=settings), 5.0, 6.0)
        A, H = numeric.matrices(np.array([5.0]))
        expected = flight.coefficients()
        np.testing.assert_array_equal(numeric.moving, MOVING)
        np.testing.assert_array_equal(H, expected.H)
        # gravity is a parameter of the model: the one entry that it makes is 2 g/r
        np.testing.assert_allclose(A, expected.A, rtol=1e-9, atol=1e-7)
        assert np.abs(A - expected.A).max() < 1e-7
        forms = numeric.covectors([one.coefficients for one in numeric.system.quantities], np.array([5.0]))[0]
        np.testing.assert_allclose(forms, flight.forms()[:, :2], atol=1e-15)


def windows_of(bundled, name, stage, *, frozen):
    numeric = NumericSystem(bundled(f"rocket/{name}.yaml", stage), 5.0, 60.0)
    settings = WindowSettings(1.5, 0.5, frozen=frozen)
    sampling = sampling_of(numeric, settings, 5.0, 12.0)
    scaling = window_scaling(numeric, None, sampling.h)
    names = [*numeric.system.state_names, *(one.name for one in numeric.system.quantities)]
    return names, joined(list(window_series(numeric, sampling, settings, scaling)))


@pytest.mark.parametrize(("stage", "frozen"), [("axes_held", True), ("flight", False)])
def test_both_bundled_models_are_one_system(bundled, stage, frozen):
    # the attitude error's axes do not change what a window shows: frozen if they are held, along it if they turn
    names, level = windows_of(bundled, "ins_gnss_enu", "flight", frozen=frozen)
    others, body = windows_of(bundled, "ins_gnss_quasi_body", stage, frozen=frozen)
    np.testing.assert_allclose(body.singular_values[:, :12], level.singular_values[:, :12], rtol=1e-8)
    for name in ("phi_x", "phi_z", "phi_U"):
        k, j = names.index(name), others.index(name)
        for values in ("equivalent", "posterior", "column_norm"):
            expected = getattr(level, values)[:, k]
            np.testing.assert_allclose(getattr(body, values)[:, j], expected, rtol=1e-6, atol=1e-9)
