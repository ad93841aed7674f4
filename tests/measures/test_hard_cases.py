"""Measures of systems whose sizes lie far apart, beside numbers found by mpmath with hundreds of digits."""

import math

import mpmath
import numpy as np
import pytest


DIGITS = 400

#: An actuator, the Schuler frequency, the Earth's rate, a bias that decays in a day.
INERTIAL = """\
parameters: {wa: 6283, ws: 1.24e-3, we: 7.29e-5}
states: [x, v, s1, s2, e1, e2, b]
A:
  - [0, 1, 0, 0, 0, 0, 0]
  - [-wa^2, -wa, 0, 0, 0, 0, 0]
  - [0, 0, 0, 1, 0, 0, 0]
  - [0, 0, -ws^2, 0, 0, 0, 0]
  - [0, 0, 0, 0, 0, we, 0]
  - [0, 0, 0, 0, -we, 0, 0]
  - [0, 0, 0, 0, 0, 0, -1.1574e-5]
H: [[1, 0, 1, 0, 1, 0, 1]]
"""
MATRIX_MEASURES = ("pseudo-inverse", "determinant", "singular-values", "equivalent-singular-value")


def near(expected, rel=1e-12):
    """Return what is equal to numbers however small; none of them is zero."""
    return pytest.approx(expected, rel=rel, abs=0)


def integrators(n, coupling):
    return np.diag([coupling] * (n - 1), 1), np.eye(n)[:1]


def inertial_matrix():
    """Return M of the inertial system."""
    wa, ws, we, b = (mpmath.mpf(one) for one in ("6283", "1.24e-3", "7.29e-5", "-1.1574e-5"))
    A = mpmath.zeros(7)
    A[0, 1], A[1, 0], A[1, 1] = 1, -wa * wa, -wa
    A[2, 3], A[3, 2] = 1, -ws * ws
    A[4, 5], A[5, 4], A[6, 6] = we, -we, b
    row, M = mpmath.matrix([[1, 0, 1, 0, 1, 0, 1]]), mpmath.zeros(7)
    for k in range(7):
        M[k, :] = row
        row = row * A
    return M


def integrated(n, coupling, time):
    """Return W of a chain of integrators, every other state with the other sign: h_j(s) = (c s)^j/j!."""
    c, T = mpmath.mpf(coupling), mpmath.mpf(time)
    terms = [c**j / mpmath.factorial(j) for j in range(n)]
    return mpmath.matrix(
        [[terms[i] * terms[j] * T ** (i + j + 1) / (i + j + 1) for j in range(n)] for i in range(n)]
    )


@pytest.mark.parametrize(
    ("A", "H", "factors"),
    [
        (np.diag([-1e6, -1e-4, -2e-4]), [[1, 1, 1]], [1, 1, 1]),
        (
            [[0, 1e4, 0, 0], [-1e4, 0, 0, 0], [0, 0, 0, 1e-6], [0, 0, -1e-6, 0]],
            [[1, 0, 1, 0]],
            [0.5**0.5] * 2,
        ),
        (np.diag([1, 1 + 1e-12]), [[1, 2]], [1, 2]),
        (np.diag([1e9, 1e-9, 1e-9]), [[1, 1, 0], [0, 0, 3]], [1, 1]),
    ],
)
def test_modes_are_told_apart_however_far_apart_their_sizes_are(A, H, factors, of_matrices):
    assert of_matrices(A, H, select=("modal",)).sizes("modal") == near(factors)


def test_a_multiple_eigenvalue_that_is_no_rational_number_stays_one(measure):
    """√2 three times, with the vectors e1 and e3; H V = (1, 1; 0, 1/1000)."""
    found = measure(
        "states: [a, b, c, d]\nH: [[1, 0, 1, 1], [0, 0, 1/1000, 1]]\n"
        "A: [[sqrt(2), 1, 0, 0], [0, sqrt(2), 0, 0], [0, 0, sqrt(2), 0], [0, 0, 0, -pi]]\n",
        select=("modal",),
    )
    smallest = np.linalg.svd([[1, 1], [0, 1e-3]], compute_uv=False)[-1]
    assert found.sizes("modal") == near([smallest, 2**0.5], rel=1e-9)


def test_eigenvalues_near_each_other_that_are_no_rational_numbers_are_two(measure):
    found = measure(
        "states: [a, b]\nH: [[1, 2]]\nA: [[sqrt(2), 0], [0, sqrt(2) + 1e-300]]\n", select=("modal",)
    )
    assert found.sizes("modal") == near([1, 2])


@pytest.mark.parametrize(
    "H", [[[1, 2, 3], [0.1, 0.2, 0.3], [7, 11, 13]], [[1, 1, 1]], [[0.1, 0.2, 0.7], [0.3, 0.6, 2.1]]]
)
def test_a_mode_of_a_multiple_eigenvalue_that_is_not_observable_has_the_factor_zero(H, of_matrices):
    """A = 0: every vector is one of the mode, and there are three."""
    assert of_matrices(np.zeros((3, 3)), H, select=("modal",)).sizes("modal") == [0]


def test_a_mode_that_hardly_shows_is_not_zero(of_matrices):
    found = of_matrices(np.diag([1.0, 2.0]), [[1, 1e-200]], select=("modal",))
    assert found.sizes("modal") == near([1e-200, 1])


def test_the_matrix_of_an_ill_conditioned_system_has_the_measures_of_exact_arithmetic(measure):
    found = measure(INERTIAL, stop="1", select=MATRIX_MEASURES)
    with mpmath.workdps(DIGITS):
        M = inertial_matrix()
        inverse = M**-1
        rows = [float(max(abs(inverse[i, j]) for j in range(7))) for i in range(7)]
        squares, V = mpmath.eigsy(M.T * M)
        sizes = [mpmath.sqrt(one) for one in squares]
        gains = [float(sum(V[k, i] ** 2 * sizes[i] for i in range(7))) for k in range(7)]
        determinant = float(mpmath.det(M) ** 2)
    assert found.state("pseudo-inverse") == near(rows)
    assert found.sizes("singular-values") == near([float(one) for one in reversed(sizes)])
    assert found.state("equivalent-singular-value") == near(gains)
    assert found.system("determinant") == near(determinant)


@pytest.mark.parametrize("seed", range(3))
def test_random_rows_of_very_different_sizes(seed, of_matrices):
    source = np.random.default_rng(seed)
    A = np.round(source.normal(size=(6, 6)), 3) * 10.0 ** source.integers(-6, 7, (6, 6))
    found = of_matrices(A, [[1, 0, 0, 0, 0, 0]], stop="1e-3", select=MATRIX_MEASURES)
    with mpmath.workdps(DIGITS):
        rows = [mpmath.matrix([[1, 0, 0, 0, 0, 0]])]
        exact = mpmath.matrix([[mpmath.mpf(repr(float(entry))) for entry in row] for row in A])
        for _ in range(5):
            rows.append(rows[-1] * exact)
        M = mpmath.matrix([[row[0, j] for j in range(6)] for row in rows])
        inverse, sizes = M**-1, mpmath.eigsy(M.T * M, eigvals_only=True)
        largest = [float(max(abs(inverse[i, j]) for j in range(6))) for i in range(6)]
        expected = [float(mpmath.sqrt(one)) for one in reversed(sizes)]
    assert found.state("pseudo-inverse") == near(largest)
    assert found.sizes("singular-values") == near(expected)


def test_singular_values_beyond_double_precision_have_no_value_and_the_condition_its_logarithm(of_matrices):
    """σ_k = 10^(−12 k): the last is 1e−348."""
    found = of_matrices(*integrators(30, 1e-12), select=("singular-values", "conventional-singular-value"))
    sizes = found.sizes("singular-values")
    assert sizes[:26] == near([10.0 ** (-12 * k) for k in range(26)])
    assert all(math.isnan(one) for one in sizes[26:])
    assert math.isnan(found.system("condition-number"))
    assert found.system("condition-number-observable-log10") == near(348)
    assert "4 singular values are beyond the range" in found.taken.found["singular-values"].remarks[0]
    assert found.state("conventional-singular-value")[26:] == [None] * 4


def test_a_determinant_beyond_double_precision_has_its_logarithm_and_no_value(of_matrices):
    """det(MᵀM) = Π 10^(−10 k), k < 16: 10^−1200; and 10^1200."""
    for coupling, logarithm in ((1e-5, -1200), (1e5, 1200)):
        found = of_matrices(*integrators(16, coupling), stop="1e-6", select=("determinant",))
        assert math.isnan(found.system("determinant"))
        assert found.system("determinant-log10") == near(logarithm)
        assert "determinant-log10" in found.taken.found["determinant"].remarks[0]


def test_a_value_of_an_observable_state_is_not_made_zero_or_infinite_by_rounding(of_matrices):
    """M = diag(1e−160, 1e−320)."""
    found = of_matrices([[0, 1e-160], [0, 0]], [[1e-160, 0]])
    for key, first in (
        ("pseudo-inverse", 1e160),
        ("column-norm", 1e-160),
        ("equivalent-singular-value", 1e-160),
    ):
        assert found.state(key) == [near(first), None]
        assert "a value is beyond the range" in found.taken.found[key].remarks[0]


def test_more_samples_than_can_be_worked_on_are_refused_at_once(of_matrices):
    found = of_matrices(*integrators(2, 1.0), options={"least-squares.N": "1e9"}, select=("least-squares",))
    reason = found.taken.found["least-squares"].reason
    assert "1000000000 samples of 2 states and 1 outputs are too many: take at most 500000" in reason


@pytest.mark.parametrize(
    ("n", "coupling", "time", "known"),
    [(8, 1.0, 1000, 8), (10, 100.0, 1000, 10), (10, 1.0, 100, 10), (26, 1e-5, 20, 14), (26, 1.0, 10, 14)],
)
def test_eigenvalues_of_the_gramian_that_are_shown_have_four_digits(n, coupling, time, known, of_matrices):
    found = of_matrices(*integrators(n, coupling), stop=str(time), select=("gramian-singular-values",))
    with mpmath.workdps(DIGITS):
        values = mpmath.eigsy(integrated(n, coupling, time), eigvals_only=True)
        expected = np.array([float(one) for one in reversed(values)])
    shown = np.array(found.sizes("gramian-singular-values"))
    there = np.isfinite(shown)
    assert there[:known].all()
    assert shown[there] == near(expected[there], rel=1e-4)
    told = found.taken.found["gramian-singular-values"].remarks
    assert bool(told) == (not there.all())


def test_another_unit_of_a_state_does_not_blur_the_gramian(measure):
    """In z = x/D the chain has couplings c D_{j+1}/D_j; the values are those of that chain."""
    text = "states: {{a: {{scale: {0}}}, b: {{scale: 1}}, c: {{scale: 1/{0}}}}}\nA: [[0, 1, 0], [0, 0, 1], [0, 0, 0]]\n"
    found = measure(
        text.format(10**9) + "H: [[1, 0, 0]]\n",
        scaling="scale",
        stop="1",
        select=("gramian-singular-values",),
    )
    with mpmath.workdps(DIGITS):
        D = mpmath.diag([10**9, 1, mpmath.mpf(10) ** -9])
        values = mpmath.eigsy(D * integrated(3, 1, 1) * D, eigvals_only=True)
    assert found.sizes("gramian-singular-values") == near([float(one) for one in reversed(values)], rel=1e-9)


def test_the_filter_is_never_worse_than_no_measurements(of_matrices):
    """Of states that learn nothing within rounding both deviations are the same: the share is 0."""
    A, H = integrators(12, 1e-5)
    prior = {f"x{k + 1}": 1 for k in range(12)}
    found = of_matrices(
        A, H, {"noise": {"R": 1, "step": 1, "P0_std": prior}}, stop="20", select=("stochastic",)
    )
    values = np.array(found.state("stochastic"))
    assert (values >= 0).all()
    assert values[0] == pytest.approx(1 - 1 / np.sqrt(1 + 21), abs=1e-2)
