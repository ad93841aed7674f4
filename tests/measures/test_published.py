"""The numbers of Bagmut 2009, recomputed with exact and 50-digit arithmetic, and what is misprinted there."""

import numpy as np
import pytest

from obscli.model.notation import to_text


g, R = 9.8, 6378137.0
GYRO = ("bagmut/gyro.yaml", "velocity")
ACCELEROMETER = ("bagmut/accelerometer.yaml", "attitude")


@pytest.mark.parametrize(
    ("model", "key", "expected", "digits"),
    [
        (GYRO, "deterministic", (1, 9.8, 1), 1e-14),
        (ACCELEROMETER, "deterministic", (1.5678559e-7, 1, 1), 1e-8),
        (GYRO, "pseudo-inverse", (1, 0.10204082, 0.10204082), 1e-7),
        (ACCELEROMETER, "pseudo-inverse", (6378137, 1, 6378137), 1e-14),
        (GYRO, "least-squares", (0.58086445, 0.022512246, 0.0035748107), 1e-7),  # printed 0.56, 0.023, 0.04
        (ACCELEROMETER, "least-squares", (5.198335e12, 1422055.4, 9.6695044e11), 1e-7),  # printed 5e13, …
    ],
)
def test_the_tables_of_the_paper(bundled, model, key, expected, digits):
    assert bundled(*model, select=(key,)).state(key) == pytest.approx(expected, rel=digits)


@pytest.mark.parametrize(
    ("model", "value", "form"),
    [(GYRO, 9223.6816, "g**4"), (ACCELEROMETER, 6.0426109e-28, "1/R**4")],
)
def test_the_generalised_determinant(bundled, model, value, form):
    found = bundled(*model, select=("determinant",))
    assert found.system("determinant") == pytest.approx(value, rel=1e-7)
    assert found.system("determinant-log10") == pytest.approx(np.log10(value), rel=1e-8)
    assert to_text(found.taken.found["determinant"].forms["determinant"]) == form


def test_closed_forms_of_both_systems(bundled):
    def forms(model, key):
        return [to_text(one) for one in bundled(*model, select=(key,)).taken.found[key].forms.values()]

    assert forms(GYRO, "deterministic") == ["1", "g", "1"]
    assert forms(GYRO, "pseudo-inverse") == ["1", "1/g", "1/g"]
    assert forms(ACCELEROMETER, "deterministic") == ["1/R", "1", "1"]
    assert forms(ACCELEROMETER, "pseudo-inverse") == ["R", "1", "R"]


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (("0.1", "101", "0.392"), (0.5579922, 0.0226744, 0.0037614)),
        (("0.01", "1001", "0.1265"), (0.5600966, 0.0228628, 0.0038097)),
    ],
)
def test_least_squares_at_other_settings(bundled, options, expected):
    given = dict(zip(("least-squares.dt", "least-squares.N", "least-squares.W"), options, strict=True))
    found = bundled(*GYRO, select=("least-squares",), options=given)
    assert found.state("least-squares") == pytest.approx(expected, rel=2e-5)


def test_where_tilt_hides_behind_the_bias_both_are_marked_whatever_a_formula_gives(bundled):
    found = bundled("bagmut/horizontal_channel.yaml", "velocity")
    assert found.state("deterministic") == pytest.approx((1, 0, 0.99483414, 0), rel=1e-7)
    assert found.state("least-squares") == pytest.approx((0.58085996, np.inf, 0.0035747414, np.inf), rel=1e-7)
    assert found.state("pseudo-inverse") == pytest.approx((1, np.inf, 0.10204082, np.inf), rel=1e-7)
    assert found.system("determinant") == 0
    assert found.system("pseudo-determinant-log10") == pytest.approx(3.9694029, rel=1e-7)
    assert [one.observable for one in found.subject.targets[:4]] == [True, False, True, False]


def test_a_ramp_in_the_output(measure):
    """A = 0, H = [1, t] at t = 3."""
    found = measure("states: [a, b]\nA: [[0, 0], [0, 0]]\nH: [[1, t]]\n", at=("3",))
    assert found.sizes("deterministic") == pytest.approx((3.1622777, 0.1), rel=1e-7)
    assert found.system("determinant-log10") == pytest.approx(0, abs=1e-12)
    assert found.state("pseudo-inverse") == pytest.approx((3, 1), rel=1e-12)


def test_a_parabola_at_the_instant_at_which_its_matrix_degenerates(measure):
    """A = 0, H = [1, t²]: det = 4 t², (17) = (max(1, t/2), 1/(2 t)); at t = 0 the matrix tells nothing of b."""
    text = "states: [a, b]\nA: [[0, 0], [0, 0]]\nH: [[1, t^2]]\n"
    found = measure(text, at=("1/2",))
    assert found.system("determinant") == pytest.approx(1, rel=1e-12)
    assert found.state("pseudo-inverse") == pytest.approx((1, 1), rel=1e-12)
    found = measure(text, at=("5",))
    assert found.state("pseudo-inverse") == pytest.approx((2.5, 0.1), rel=1e-12)
    at_zero = measure(text, at=("0",)).taken.found["pseudo-inverse"]
    assert "of a lower rank than 2 at t = 0" in at_zero.reason


def test_the_calibrated_states_of_the_ins_are_those_with_finite_values(bundled):
    """24 states at t = 7, by 120 digits in the digest: finite for exactly 12."""
    found = bundled("ins_calibration/horizontal.yaml", "stage_1", at=("7",), select=("pseudo-inverse",))
    finite = [
        name
        for name, value in zip(found.subject.system.state_names, found.state("pseudo-inverse"), strict=True)
        if np.isfinite(value)
    ]
    assert finite == [
        "psi1",
        "b_a2",
        "b_a3",
        "M_g12",
        "M_g13",
        "M_g22",
        "M_g23",
        "M_g32",
        "M_g33",
        "M_a22",
        "M_a32",
        "M_a33",
    ]


@pytest.mark.parametrize("unit", [60.0])
def test_values_in_minutes(measure, unit):
    """With the minute as unit of time the pseudo-inverse gives (1, 1.7007e-3, 2.8345e-5), (1.0630e5, 1, 1771.7)."""
    gyro = f"states: [v, a, w]\nA: [[0, {-g * unit}, 0], [{unit}/6378137, 0, {unit}], [0, 0, 0]]\nH: [[1, 0, 0]]\n"
    accelerometer = f"states: [v, a, w]\nA: [[0, {-g * unit}, {unit}], [{unit}/6378137, 0, 0], [0, 0, 0]]\nH: [[0, 1, 0]]\n"
    assert measure(gyro).state("pseudo-inverse") == pytest.approx((1, 1.7007e-3, 2.8345e-5), rel=1e-4)
    assert measure(accelerometer).state("pseudo-inverse") == pytest.approx((1.0630e5, 1, 1771.7), rel=1e-4)


@pytest.mark.parametrize("n", [3, 20])
def test_a_small_determinant_does_not_mean_a_badly_observed_state(of_matrices, n):
    """H = I/2, A = 0: det = 4^-n, and an error of an output enters doubled, no more."""
    found = of_matrices(np.zeros((n, n)), np.eye(n) / 2)
    assert found.system("determinant") == pytest.approx(4.0**-n, rel=1e-12)
    assert found.state("pseudo-inverse") == pytest.approx([2] * n)


def test_a_large_determinant_does_not_mean_that_all_are_well_observed(of_matrices):
    found = of_matrices(np.zeros((2, 2)), [[1e6, 0], [0, 1e-3]])
    assert found.system("determinant") == pytest.approx(1e6)
    assert found.state("pseudo-inverse") == pytest.approx((1e-6, 1000))
