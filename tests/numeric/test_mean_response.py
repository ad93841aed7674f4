"""The mean response to an initial error: an independent recursion, linearity, feedback, the flights of a rocket."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm, sqrtm

from obscli.model.reader import load
from obscli.numeric.errors import UnfitRequestError
from obscli.numeric.feedback import Feedback
from obscli.numeric.kalman import covariance_history
from obscli.numeric.linear_forms import forms_of
from obscli.numeric.mean_response import mean_response
from obscli.numeric.mismatched import mismatch_history
from obscli.numeric.monte_carlo import monte_carlo
from obscli.numeric.recorded_errors import recorded_errors
from obscli.numeric.sampled_system import SampledSystem
from obscli.numeric.schedule import schedule_of
from obscli.numeric.well_observable import equivalent_at_samples


TURNING = """\
states: [x, y, b]
dynamics: {x: cos(t)*y + b, y: -x/3 - y/5, b: -b/40}
measurements: {p: x, q: y + sin(t/2)*b}
noise: {R: [[0.04, 0.05], [0.05, 0.25]], step: 0.25, P0_std: [1, 2, 0.5], Q: {x: 0.1, b: 0.01}}
quantities: {turned: cos(t)*x + sin(t)*y}
"""
TRUE = """\
states: [x, v, b, c]
A: [[0, 1, 0, 0], [-1/2, -1/10, 1, 0.3], [0, 0, -1/9, 0], [0, 0, 0, 0]]
measurements: {p: x}
noise: {R: 0.04, step: 0.5, P0_std: [1, 2, 0.5, 0.5], Q: [0, 0.1, 0.02, 0]}
"""
FILTER = """\
states: [v, x, b]
A: [[0, -1/3, 1], [1, 0, 0], [0, 0, 0]]
measurements: {p: x}
noise: {R: 0.09, step: 0.5, P0_std: [1, 1, 0.5], Q: [0.2, 0, 0.01]}
"""
DISCRETE = """\
states: [x, v]
F: [[0, 1], [0, 1/2]]
measurements: {p: x}
noise: {R: 1, P0_std: [1, 2]}
interval: {stop: 10}
"""
A_TRUE = np.array([[0, 1, 0, 0], [-0.5, -0.1, 1, 0.3], [0, 0, -1 / 9, 0], [0, 0, 0, 0]])
A_OWN = np.array([[0, -1 / 3, 1], [1, 0, 0], [0, 0, 0]])
WAYS = [None, Feedback(), Feedback(("b",)), Feedback(("v", "x")), Feedback(below=0.5)]


def responds(given, initial, stop, design=None, start=0, **options):
    own = design or given
    schedules = [schedule_of(one, start, stop) for one in (given, own)]
    other = {} if design is None else {"filter_": design, "filter_schedule": schedules[1]}
    run = recorded_errors(given, schedules[0], forms_of(own), 5000, **other, **options)
    return mean_response(run, np.array(initial))


def by_hand(initial, stop, taken):
    """Return e after every sample by the INS and the filter themselves, and the gains of the Riccati equation."""
    E = np.array([[0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0]], dtype=float)
    blocks = np.zeros((6, 6))  # van Loan
    blocks[:3, :3], blocks[:3, 3:], blocks[3:, 3:] = -A_OWN, np.diag([0.2, 0, 0.01]), A_OWN.T
    moved = expm(0.5 * blocks)
    own = moved[3:, 3:].T
    noise, true = own @ moved[:3, 3:], expm(0.5 * A_TRUE)
    H, P, x, estimate, found = (
        np.array([[0, 1.0, 0]]),
        np.diag([1, 1, 0.25]),
        np.array(initial),
        np.zeros(3),
        [],
    )
    for k in range(round(stop / 0.5) + 1):
        if k:
            x, estimate, P = true @ x, own @ estimate, own @ P @ own.T + noise
        gain = P @ H.T / (H @ P @ H.T + 0.09)
        estimate = estimate + gain @ (H @ E @ x - H @ estimate)
        P = P - gain @ H @ P
        mask = taken(np.sqrt(np.diag(P)) / [1, 1, 0.5])
        x, estimate = x - E.T @ (mask * estimate), np.where(mask, 0, estimate)
        found.append(E @ x - estimate)
    return np.array(found)


@pytest.mark.parametrize(
    ("feedback", "taken"),
    [
        (None, lambda _: np.zeros(3, bool)),
        (Feedback(), lambda _: np.ones(3, bool)),
        (Feedback(("b", "v")), lambda _: np.array([True, False, True])),
        (Feedback(below=0.5), lambda ratio: ratio < 0.5),
    ],
)
def test_a_filter_on_another_truth_is_that_of_its_recursion(system, feedback, taken):
    initial = [1.0, -2.0, 0.5, 0.7]
    found = responds(system(TRUE), initial, 20, system(FILTER), feedback=feedback)
    expected = by_hand(initial, 20, taken)
    place = [int(np.abs(found.t - 0.5 * k).argmin()) for k in range(41)]
    assert found.mean[place] == pytest.approx(expected, abs=1e-10)
    assert found.before == pytest.approx([-2.0, 1.0, 0.5])


def test_the_states_that_are_well_observable_are_fed_back(system):
    """σ̃ is the diagonal of (RᵀR)^½, R of as many samples as states, in units of P0 and the noise."""
    truth, own = system(TRUE), system(FILTER)
    step = expm(0.5 * A_OWN)
    R = np.array([[0, 1.0, 0] @ np.linalg.matrix_power(step, j) for j in range(3)]) * [1, 1, 0.5] / 0.3
    v, x, b = np.diag(sqrtm(R.T @ R)).real
    assert b < v < x
    initial = [1.0, -2.0, 0.5, 0.7]
    for above, states in (((v + x) / 2, ("x",)), ((v + b) / 2, ("x", "v")), (b / 2, None)):
        found = responds(truth, initial, 20, own, feedback=Feedback(above=above))
        expected = responds(truth, initial, 20, own, feedback=Feedback(states))
        np.testing.assert_allclose(found.mean, expected.mean, rtol=1e-12, atol=1e-14)
    both = responds(truth, initial, 20, own, feedback=Feedback(("v", "b"), above=(v + b) / 2))
    only = responds(truth, initial, 20, own, feedback=Feedback(("v",)))
    np.testing.assert_allclose(both.mean, only.mean, rtol=1e-12, atol=1e-14)


def test_what_is_well_observable_changes_along_the_way(system):
    given = system(TURNING)
    schedule = schedule_of(given, 0, 10)
    found = equivalent_at_samples(SampledSystem(given, schedule))
    whitening = np.linalg.inv(np.linalg.cholesky([[0.04, 0.05], [0.05, 0.25]]))
    for k in (0, 7, 40):
        t = schedule.t[k]
        A = np.array([[0, np.cos(t), 1], [-1 / 3, -1 / 5, 0], [0, 0, -1 / 40]])
        H = whitening @ np.array([[1, 0, 0], [0, 1, np.sin(t / 2)]])
        R = np.concatenate([H @ expm(0.25 * j * A) for j in range(3)]) * [1, 2, 0.5]
        np.testing.assert_allclose(found[k], np.diag(sqrtm(R.T @ R)).real, rtol=1e-9)


RATES = """\
states: [x, v]
A: [[0, 1], [0, 0]]
measurements: {y: x, z: v}
outputs: {y: {every: 0.3}, z: {every: 0.2}}
noise: {R: {y: 0.01, z: 0.04}, P0_std: [1, 2]}
"""
SLOW = """\
states: [p, v]
F: [[1, 1], [0, 0.9]]
measurements: {y: p}
outputs: {y: {every: 2}}
noise: {R: 0.01, P0_std: [1, 1]}
interval: {stop: 10}
"""


def test_windows_have_the_samples_of_the_filter(system):
    """Outputs of several rates, steps that are asked for, several steps of discrete time between samples."""

    def found(text, stop, step=None):
        given = system(text)
        return equivalent_at_samples(SampledSystem(given, schedule_of(given, 0, stop, step)))

    def expected(rows):
        return np.diag(sqrtm(rows.T @ rows)).real

    rates = found(RATES, 1.2)  # at 0: y, z; 0.2: z; 0.3: y; 0.4: z; 0.6: y, z; …; 1.2: y, z
    np.testing.assert_allclose(rates[0], expected(np.array([[10, 0], [0, 10], [0, 10]])), rtol=1e-9)
    np.testing.assert_allclose(rates[1], expected(np.array([[0, 10], [10, 2]])), rtol=1e-9)
    np.testing.assert_allclose(rates[-1], rates[-2], rtol=1e-9)
    dense = "states: [x, v]\nA: [[0, 1], [0, 0]]\nH: [[1, 0]]\nnoise: {R: 0.01, step: 0.5, P0_std: [1, 1]}\n"
    for step, h in ((None, 0.5), (0.1, 0.1)):
        one = found(dense, 5, step)
        np.testing.assert_allclose(one[3], expected(np.array([[10, 0], [10, 10 * h]])), rtol=1e-9)
    F = np.array([[1, 1], [0, 0.9]])
    rows = np.concatenate([[[10.0, 0]], np.array([[10.0, 0]]) @ F @ F])
    np.testing.assert_allclose(found(SLOW, 10)[2], expected(rows), rtol=1e-9)


def test_what_is_fed_back_matters_where_the_truth_is_another(system):
    found = [responds(system(TRUE), [1.0, 0, 0, 1], 20, system(FILTER), feedback=one) for one in WAYS]
    for k, one in enumerate(found):
        assert all(np.abs(one.mean - other.mean).max() > 1e-3 for other in found[:k])


@pytest.mark.parametrize("text", [TURNING, DISCRETE])
@pytest.mark.parametrize("way", [Feedback(), Feedback(("x",)), Feedback(below=0.3)])
def test_of_equal_models_errors_are_the_same_whatever_is_fed_back(system, text, way):
    given = system(text)
    initial = [0.3, -1.0, 2.0][: given.n]
    alone = responds(given, initial, 10)
    again = responds(given, initial, 10, feedback=way)
    other = responds(given, initial, 10, given, feedback=way)
    assert again.mean == pytest.approx(alone.mean, abs=1e-10)
    assert other.mean == pytest.approx(alone.mean, abs=1e-10)


def test_deviations_and_runs_of_equal_models_are_the_same_with_feedback(system):
    given = system(TURNING)
    schedule, forms = schedule_of(given, 0, 10), forms_of(given)
    found = mismatch_history(recorded_errors(given, schedule, forms, filter_=given, feedback=Feedback()))
    alone = covariance_history(given, schedule, forms)
    assert found.true == pytest.approx(alone.deviations, rel=1e-10)
    one, other = (
        monte_carlo(recorded_errors(given, schedule, forms, feedback=way), 20, 3)
        for way in (None, Feedback())
    )
    assert other.rms == pytest.approx(one.rms, rel=1e-10)
    assert other.nees.average == pytest.approx(one.nees.average, rel=1e-8)


def test_true_deviations_are_those_of_the_runs_with_feedback(system):
    truth, design = system(TRUE), system(FILTER)
    schedules = [schedule_of(one, 0, 20) for one in (truth, design)]
    way = Feedback(("x", "v"))
    run = recorded_errors(
        truth,
        schedules[0],
        forms_of(design),
        200,
        filter_=design,
        filter_schedule=schedules[1],
        feedback=way,
    )
    found, runs = mismatch_history(run), monte_carlo(run, 2000, 1)
    place = [int(np.abs(found.t - t).argmin()) for t in runs.t]
    assert (np.abs(runs.rms / found.true[place] - 1) < 5 / np.sqrt(4000)).all()


def test_the_response_is_linear_and_that_of_the_closed_loop(system):
    """Of all unit errors together it is the transition matrix of the filter, which takes P0 to P without noise."""
    given = system(TURNING)
    units = [responds(given, row, 10) for row in np.eye(3)]
    both = responds(given, [2.0, -1.0, 0.25], 10)
    assert both.mean == pytest.approx(2 * units[0].mean - units[1].mean + units[2].mean / 4, abs=1e-12)
    assert both.before == pytest.approx([2.0, -1.0, 0.25, 2.0])
    P = covariance_history(given, schedule_of(given, 0, 10), forms_of(given), recorded=5000).deviations
    part = np.sqrt(sum((one.mean * sigma) ** 2 for one, sigma in zip(units, [1, 2, 0.5], strict=True)))
    assert (part <= P * (1 + 1e-9)).all()


def test_states_of_one_model_alone_are_not_fed_back(system):
    truth, design = system(TRUE), system(FILTER)
    with pytest.raises(UnfitRequestError, match="--feedback c: no state of the filter"):
        responds(truth, [1.0, 0, 0, 0], 2, design, feedback=Feedback(("c",)))
    with pytest.raises(UnfitRequestError, match="--feedback c: no state of the true model"):
        responds(design, [1.0, 0, 0], 2, truth, feedback=Feedback(("c",)))
    everything = responds(design, [1.0, 0, 0], 9, truth, feedback=Feedback())
    named = responds(design, [1.0, 0, 0], 9, truth, feedback=Feedback(("x", "v", "b")))
    assert everything.mean == pytest.approx(named.mean, abs=1e-12)


_spec = importlib.util.spec_from_file_location("flights", Path(__file__).with_name("flights.py"))
FLIGHTS = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(FLIGHTS)

FLIGHT = """\
signals:
  file: {file}
  time: t_s
  columns:
    f_x: fq_x
    f_y: fq_y
    f_z: fq_z
    v_E: vE
    v_N: vN
    v_U: vU
    pitch: {{column: pitch_deg, factor: pi/180}}
    heading: {{column: heading_deg_ccw_from_N, factor: pi/180}}
"""
GRADE = """\
quantities: {dgamma: phi_x - phi_y*sin(pitch)/cos(pitch), dpsi: phi_y/cos(pitch)}
noise:
  R: {velocity: 0.2^2, position: 5^2}
  P0_std: {phi: 5*pi/180, dv: 0.5, dp: 10, eps: 360*pi/180/3600, nabla: 10e-3*9.80665}
  Q: {phi: (pi/180/60)^2}
outputs: {velocity: {every: 0.1, during: [[5.1, 200]]}, position: {every: 0.1, during: [[5.1, 200]]}}
interval: {start: 5, stop: 24}
"""


@pytest.fixture(scope="module")
def flights(tmp_path_factory, root):
    """The bundled model in quasi-body axes along the three flights, with the sensors of grade B."""
    folder = tmp_path_factory.mktemp("flights")
    text = (root / "models/rocket/ins_gnss_quasi_body.yaml").read_text()
    head, rest = text.split("functions:", 1)
    rest = rest.split("\n", 1)[1].split("quantities:", 1)[0].replace("rotx(roll)", "rotx(0)")

    def read(case):
        signals = FLIGHT.format(file=root / f"tests/numeric/data/flight_{case}.csv")
        file = folder / f"{case}.yaml"
        file.write_text(head + signals + rest + GRADE)
        return load(file).systems[0]

    return {case: read(case) for case in ("uncontrolled", "pitch", "yaw")}


def inserted(given, error, stop, **options):
    initial = np.zeros(15)
    for name, value in error.items():
        initial[given.state_names.index(name)] = np.deg2rad(value)
    found = responds(given, initial, stop, start=5, **options)

    def at(name, t):
        k = int(np.abs(found.t - t).argmin())
        assert found.t[k] == pytest.approx(t)
        return np.rad2deg(found.mean[k, found.names.index(name)])

    return at


def by_matrices(case, initial, stop):
    """Return (Dgamma, Dpsi) in degrees after every sample: East-North-Up, A averaged over 0.1 s, entry by entry."""
    flight = FLIGHTS.Flight(case)
    A = np.pad(flight.coefficients().A, [(0, 0), (0, 6), (0, 0)])
    P = np.diag(np.repeat(np.array([np.deg2rad(5), 0.5, 10, np.deg2rad(0.1), 10e-3 * 9.80665]) ** 2, 3))
    Q = np.diag(np.repeat([np.deg2rad(1 / 60) ** 2, 0, 0, 0, 0], 3))
    H, R = np.eye(15)[3:9], np.diag(np.repeat([0.2**2, 5**2], 3))
    e, found = np.concatenate([flight.C[0] @ np.deg2rad(initial), np.zeros(12)]), {}
    for k in range(1, round(10 * (stop - 5)) + 1):
        phi = expm((A[k - 1] + A[k]) / 20)
        P, e = phi @ P @ phi.T + Q / 10, phi @ e
        closed = np.eye(15) - P @ H.T @ np.linalg.inv(H @ P @ H.T + R) @ H
        P, e = closed @ P, closed @ e
        x, y, _ = np.rad2deg(flight.C[k].T @ e[:3])
        pitch = np.deg2rad(flight.data["pitch_deg"][k])
        found[round(5 + k / 10, 1)] = x - y * np.tan(pitch), y / np.cos(pitch)
    return found


@pytest.mark.parametrize("case", FLIGHTS.CASES)
@pytest.mark.parametrize("initial", [(5, 0, 0), (2, 4, 1)])
def test_along_a_flight_it_is_the_recursion_in_other_axes(flights, case, initial):
    at = inserted(flights[case], dict(zip(("phi_x", "phi_y", "phi_z"), initial, strict=True)), 13)
    expected = by_matrices(case, initial, 13)
    for t in (5.1, 5.2, 5.5, 6, 9.9, 12, 13):
        assert (at("dgamma", t), at("dpsi", t)) == pytest.approx(expected[t], abs=2e-3)


def test_a_roll_error_stays_until_the_rocket_manoeuvres(flights):
    """Against a strapdown INS and a filter written apart, nonlinear: a linear filter is to agree to 0.036 deg.

    That number and the table's are rounded, half a digit each.
    """
    near = 0.036 + 2 * 0.0005
    at = inserted(flights["uncontrolled"], {"phi_x": 5}, 22)
    assert at("dgamma", 9.9) == pytest.approx(4.573, rel=1e-3)
    assert at("dgamma", 22) == pytest.approx(3.878, rel=1e-3)
    for case, value in (("pitch", -0.021), ("yaw", 0.009)):
        assert inserted(flights[case], {"phi_x": 5}, 13)("dgamma", 13) == pytest.approx(value, abs=near)


def test_an_azimuth_error_goes_and_leaves_its_part_about_the_nose(flights):
    """Only phi_y = Dpsi cos(pitch) is seen: Dgamma = (Dpsi0 - Dpsi) sin(pitch) is left, to 1 %."""
    at = inserted(flights["uncontrolled"], azimuth(), 7)
    for t, value in ((5.1, 4.518), (5.2, 3.058), (5.5, 0.540), (6, 0.104)):
        assert at("dpsi", t) == pytest.approx(value, abs=0.01)
    t = np.arange(51, 61) / 10
    slope, _ = np.polyfit([at("dpsi", one) for one in t], [at("dgamma", one) for one in t], 1)
    assert -slope == pytest.approx(0.5769, rel=0.01)


def azimuth():
    pitch = np.deg2rad(35.4642627)
    return {"phi_x": 5 * np.sin(pitch), "phi_y": 5 * np.cos(pitch)}


def test_feedback_and_output_correction_agree_along_a_flight(flights):
    ways = (None, Feedback(), Feedback(("phi_z", "dv_E", "dp_U")))
    roll = [inserted(flights["yaw"], {"phi_x": 5}, 12, feedback=way) for way in ways]
    for t in (6, 9, 11, 12):
        assert [at("phi_x", t) for at in roll] == pytest.approx(3 * [roll[0]("phi_x", t)], abs=1e-10)
