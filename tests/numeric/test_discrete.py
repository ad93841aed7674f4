"""Discrete-time systems in floating point: sums, filters and products written out, and what needs no inverse."""

import numpy as np
import pytest
from scipy.linalg import expm

from obscli.model.reader import load, read_text
from obscli.numeric.analysis import analyze
from obscli.numeric.dense_transition import dense_transitions
from obscli.numeric.discrete_gramian import discrete_gramian
from obscli.numeric.errors import NotComputableError, UnfitRequestError
from obscli.numeric.horizon import Wanted, horizon_of
from obscli.numeric.information_bound import information_roots
from obscli.numeric.kalman import covariance_history, roots_at
from obscli.numeric.linear_forms import forms_of
from obscli.numeric.mismatched import mismatch_history
from obscli.numeric.monte_carlo import monte_carlo
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.partners import knowledge
from obscli.numeric.recorded_errors import recorded_errors
from obscli.numeric.riccati import cross_check
from obscli.numeric.schedule import schedule_of
from obscli.numeric.settings import Effort, Settings
from obscli.numeric.trajectory import follow
from obscli.numeric.transition import panels


TURNING = """\
parameters: {w: 0.7}
states: [x, y, b]
F: [[cos(w*k), 1, 0.2], [0, 1 + 0.1*sin(k), 0], [0, 0, 0.5]]
H: [[1, 0, 0], [0, k/10, 1]]
interval: {stop: 12}
"""
NOISE = "noise: {R: [0.04, 0.25], Q: [0.01, 0.02, 0.3], P0_std: [1, 2, 0.5]}\n"


def read(text):
    return read_text(text, "test").systems[0]


def matrices(k):
    F = np.array([[np.cos(0.7 * k), 1, 0.2], [0, 1 + 0.1 * np.sin(k), 0], [0, 0, 0.5]])
    return F, np.array([[1, 0, 0], [0, k / 10, 1.0]])


def constant(F, H, more=""):
    def rows(matrix):
        return [[repr(float(e)) for e in row] for row in matrix]

    text = f"states: {[f'x{j}' for j in range(len(F))]}\nF: {rows(F)}\nH: {rows(H)}\n{more}"
    return read(text.replace("'", ""))


def gramian(F, H, first, last):
    """W(k, K) = Σ Φᵀ Hᵀ H Φ, as it is defined."""
    W, phi = 0, np.eye(3)
    for k in range(first, last + 1):
        W = W + phi.T @ H(k).T @ H(k) @ phi
        phi = F(k) @ phi
    return W


# -- the Gramian


def test_the_gramian_is_the_sum():
    found = discrete_gramian(NumericSystem(read(TURNING), 0, 12), np.array([0.0, 3.0, 7.0, 12.0]), 12.0)
    assert found.starts.tolist() == [12.0] * 4
    for k, R, units in zip(found.instants, found.matrices, found.units, strict=True):
        expected = gramian(lambda i: matrices(i)[0], lambda i: matrices(i)[1], int(k), 12)
        assert pytest.approx(expected * units * units[:, None], rel=1e-12, abs=1e-13) == R.T @ R


def test_the_error_covers_rounding():
    """R v for unobservable v of a random orthogonal change of variables is within the error."""
    rng = np.random.default_rng(0)
    for _ in range(5):
        T = np.linalg.qr(rng.normal(size=(4, 4)))[0]
        F = np.diag([0.9, -0.7, 1.0, 1.1])
        H = np.array([[1.0, 1.0, 0.0, 0.0]])
        found = discrete_gramian(NumericSystem(constant(T @ F @ T.T, H @ T.T), 0, 60), np.array([0.0]), 60.0)
        v = T[:, 2] / found.units[0]
        wrong = np.linalg.norm(found.matrices[0] @ v)
        assert wrong <= 10 * np.sqrt(v @ found.error[0] @ v)
        assert wrong <= 1e-12


@pytest.mark.parametrize(("H", "rank"), [([[0, 0, 1]], 3), ([[1, 0, 0]], 1), ([[0, 1, 0]], 2)])
def test_a_singular_matrix_needs_no_inverse(H, rank):
    found = analyze(constant([[0, 0, 0], [1, 0, 0], [0, 1, 0]], H), Settings())
    assert found.rank == rank
    assert found.conclusive.all()


def test_growth_does_not_hide_the_rest():
    """An eigenvalue of 8 over 80 steps: 1e72 beside 1e-18; shorter windows show both."""
    T = np.array([[1, 2, 0], [0, 1, 1], [1, 0, 1.0]])
    F = T @ np.diag([8, 0.5, 0.6]) @ np.linalg.inv(T)
    given = constant(F, np.array([[1, 1, 1.0]]) @ np.linalg.inv(T), "interval: {stop: 80}")
    found = analyze(given, Settings())
    assert found.rank == 3
    assert found.window is not None
    assert found.conclusive.mean() > 0.9


@pytest.mark.parametrize("period", [0.1, 0.7])
def test_sampling_keeps_the_kernel(period):
    A = np.array([[0, 1, 0], [-4, -0.3, 0], [1, 0, 0.0]])
    H = np.array([[0, 1.0, 0]])
    found = analyze(constant(expm(A * period), H, "interval: {stop: 40}"), Settings())
    kernel = found.spaces.kernel(0)[:, 0] * found.spaces.gramian.units[0]
    assert found.rank == 2
    assert abs(kernel) == pytest.approx([0, 0, 1], abs=1e-12)


def test_the_critical_sampling_period_at_the_files_values(request):
    file = request.config.rootpath / "models/discrete/sampled_oscillator.yaml"
    assert analyze(load(file).systems[0], Settings()).rank == 2
    assert analyze(load(file, settings={"T": "pi/2"}).systems[0], Settings()).rank == 1


def test_the_steps_that_are_looked_at():
    assert horizon_of(read(TURNING), Wanted()).instants.tolist() == list(range(11))  # at least n samples each
    assert horizon_of(read(TURNING.replace("interval: {stop: 12}", "")), Wanted()).stop == 20
    assert horizon_of(read(TURNING), Wanted(samples=3)).instants.tolist() == [0, 5, 10]


@pytest.mark.parametrize("method", ["lyapunov", "quadrature", "lift"])
def test_methods_of_continuous_time_are_refused(method):
    with pytest.raises(UnfitRequestError, match=method):
        analyze(read(TURNING), Settings(method=method))


def test_an_end_between_two_steps_is_refused():
    with pytest.raises(NotComputableError, match="whole numbers"):
        horizon_of(read(TURNING.replace("12", "12.5")), Wanted())


def test_a_trajectory_is_the_product():
    found = follow(analyze(read(TURNING), Settings()), np.array([1.0, -2.0, 0.5]), 4)
    x = np.array([1.0, -2.0, 0.5])
    states = [x]
    for k in range(12):
        x = matrices(k)[0] @ x
        states.append(x)
    assert found.states == pytest.approx(np.array(states)[found.instants.astype(int)], rel=1e-13)


def test_nothing_integrates_a_discrete_time_system():
    """Whoever does not know of discrete time is refused where panels are made."""
    numeric = NumericSystem(read(TURNING), 0, 12)
    for made in (
        panels(numeric, np.array([0.0, 1.0]), Effort(1e-12, 10)),
        dense_transitions(numeric, np.array([0.0, 1.0])),
    ):
        with pytest.raises(NotComputableError, match="discrete-time"):
            next(iter(made))


# -- filters


def dense_filter(steps, prior=(1, 4, 0.25)):
    """The Kalman filter as books have it, covariances by subtraction."""
    R, Q, P = np.diag([0.04, 0.25]), np.diag([0.01, 0.02, 0.3]), np.diag(prior)
    found = []
    for k in range(steps + 1):
        F, H = matrices(k)
        gain = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
        P = P - gain @ H @ P
        found.append(P)
        P = F @ P @ F.T + Q
    return found


def test_the_filter_is_that_of_the_books():
    given = read(TURNING + NOISE)
    schedule = schedule_of(given, 0.0, 12.0)
    history = covariance_history(given, schedule, forms_of(given))
    assert history.t.tolist() == list(range(13))
    expected = np.sqrt([np.diag(P) for P in dense_filter(12)])
    assert history.deviations == pytest.approx(expected, rel=1e-10)
    roots, opened = roots_at(given, schedule, np.array([4.0, 12.0]))
    assert roots[1] @ roots[1].T == pytest.approx(dense_filter(12)[12], rel=1e-10, abs=1e-13)
    P = np.diag([1, 4, 0.25])
    for k in range(4):
        P = matrices(k)[0] @ P @ matrices(k)[0].T + np.diag([0.01, 0.02, 0.3])
    assert opened[0].value @ opened[0].value.T == pytest.approx(P, rel=1e-12, abs=1e-14)


def test_noise_enters_by_its_matrix():
    scalar = "states: [x]\nF: [[1]]\nG: [[1 + k]]\nH: [[1]]\nnoise: {R: 1, Q: 4, P0_std: 1}\n"
    given = read(scalar)
    _, opened = roots_at(given, schedule_of(given, 0.0, 3.0), np.array([3.0]))
    assert opened[0].value[0, 0] ** 2 == pytest.approx(1 + 4 * (1 + 4 + 9))  # G(0), G(1), G(2)


def test_a_singular_matrix_forgets():
    """After F = 0 what is known is what has entered since."""
    given = read("states: [x]\nF: [[0]]\nH: [[1]]\nnoise: {R: 1, Q: 9, P0_std: 5}\n")
    history = covariance_history(given, schedule_of(given, 0.0, 4.0), forms_of(given))
    assert history.deviations[1:, 0] ** 2 == pytest.approx([0.9] * 4)


def test_outputs_every_so_many_steps_with_outages():
    text = f"{TURNING}outputs: {{y1: {{every: 3}}, y2: {{during: [[0, 2]]}}}}\n"
    given = read(text + NOISE)
    schedule = schedule_of(given, 0.0, 12.0)
    assert [t for t, one in zip(schedule.t, schedule.sampled[:, 0], strict=True) if one] == [0, 3, 6, 9, 12]
    assert schedule.sampled[:, 1].sum() == 3
    assert np.diag(schedule.R) == pytest.approx([0.04, 0.25])


def test_every_must_be_whole():
    given = read(f"{TURNING}outputs: {{y1: {{every: 1.5}}}}\n{NOISE}")
    with pytest.raises(NotComputableError, match="whole steps"):
        schedule_of(given, 0.0, 12.0)


def test_a_step_asked_for_is_refused():
    with pytest.raises(UnfitRequestError, match="--step"):
        schedule_of(read(TURNING + NOISE), 0.0, 12.0, 0.5)


def test_a_filter_on_its_own_model_claims_what_is_true():
    given = read(TURNING + NOISE)
    schedule = schedule_of(given, 0.0, 12.0)
    found = mismatch_history(recorded_errors(given, schedule, forms_of(given), filter_=given))
    assert found.true == pytest.approx(found.claimed, rel=1e-9)


def test_a_filter_on_a_wrong_model():
    """P of the error by the recursion e⁺ = (I − K H_f) (F_f e + ΔF x) of the joint state, for a scalar."""
    truth = read("states: [x]\nF: [[0.9]]\nH: [[1]]\nnoise: {R: 1, Q: 0.5, P0_std: 2}\n")
    own = read("states: [x]\nF: [[0.5]]\nH: [[1]]\nnoise: {R: 1, Q: 0.5, P0_std: 2}\n")
    schedule = schedule_of(truth, 0.0, 6.0)
    found = mismatch_history(recorded_errors(truth, schedule, forms_of(own), filter_=own))
    P, joint = 4.0, np.full((2, 2), 4.0)
    for k in range(7):
        gain = P / (P + 1)
        update = np.array([[1, 0], [0, 1 - gain]])
        joint = update @ joint @ update.T + np.diag([0, gain**2])
        P = P * (1 - gain)
        assert found.claimed[k, 0] == pytest.approx(np.sqrt(P))
        assert found.true[k, 0] == pytest.approx(np.sqrt(joint[1, 1]))
        onward = np.array([[0.9, 0], [0.9 - 0.5, 0.5]])
        joint = onward @ joint @ onward.T + 0.5
        P = 0.25 * P + 0.5


def test_random_runs_are_consistent():
    given = read(TURNING + NOISE)
    found = monte_carlo(recorded_errors(given, schedule_of(given, 0.0, 12.0), forms_of(given)), 400, 1)
    assert found.rms[-1] == pytest.approx(found.claimed[-1], rel=0.15)
    assert found.nees.inside > 0.7


def test_the_information_of_the_samples_alone():
    """(Σ Φᵀ Hᵀ R⁻¹ H Φ) on the first state, moved to the last, without driving noise."""
    given = read(TURNING + "noise: {R: [0.04, 0.25], P0_std: [1, 2, 0.5]}\n")
    [known] = information_roots(given, schedule_of(given, 0.0, 5.0), np.array([5.0]))
    J, phi = 0, np.eye(3)
    for k in range(6):
        F, H = matrices(k)
        J = J + phi.T @ H.T @ np.diag([25.0, 4.0]) @ H @ phi
        phi = (F if k < 5 else np.eye(3)) @ phi
    back = np.linalg.inv(phi)
    root = known.columns.value.T
    assert root.T @ root == pytest.approx(back.T @ J @ back, rel=1e-9, abs=1e-9)


def test_information_through_a_singular_matrix_is_refused():
    given = read("states: [x]\nF: [[0]]\nH: [[1]]\nnoise: {R: 1, P0_std: 5}\n")
    with pytest.raises(NotComputableError, match="F is singular"):
        information_roots(given, schedule_of(given, 0.0, 3.0), np.array([3.0]))


def test_the_riccati_equation_from_two_priors():
    given = read(TURNING + NOISE)
    found = cross_check(given, 0.0, 12.0)
    for prior, deviations in (((1, 4, 0.25), found.deviations), ((4, 16, 1.0), found.wider)):
        expected = dense_filter(12, prior)
        for j, name in enumerate("xyb"):
            values = [np.sqrt(expected[int(k)][j, j]) for k in found.instants]
            assert deviations[name] == pytest.approx(values, rel=1e-9)


def test_how_well_a_state_is_known():
    given = read(TURNING + NOISE)
    target = {"x": forms_of(given).covectors[0]["x"]}
    found = knowledge(given, target, 0.0, 12.0)
    assert found.after == pytest.approx(np.sqrt(dense_filter(12)[12][0, 0]), rel=1e-9)
