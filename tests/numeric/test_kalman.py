"""The covariance of the Kalman filter: identities, independent filters, published numbers."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from scipy.linalg import expm

from obscli.model.expression import number
from obscli.numeric.errors import NotComputableError
from obscli.numeric.kalman import covariance_history, roots_at
from obscli.numeric.linear_forms import forms_of
from obscli.numeric.noise import noise_model
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.riccati import covariances, samples_of
from obscli.numeric.schedule import schedule_of
from obscli.numeric.simulation_finding import History
from obscli.numeric.time_to_observability import times_to_observability


CHANNEL = """\
parameters: {{g: 9.8, R0: 6378137}}
states: [dv, alpha, {drift}]
A: {A}
H: {H}
noise: {{R: {R}, step: 1, P0_std: [1, 1e-3, {sigma}]}}
"""
GYRO = CHANNEL.format(
    drift="domega", A="[[0, -g, 0], [1/R0, 0, 1], [0, 0, 0]]", H="[[1, 0, 0]]", R="1e-4", sigma="1e-4"
)
ACCELEROMETER = CHANNEL.format(
    drift="da", A="[[0, -g, 1], [1/R0, 0, 0], [0, 0, 0]]", H="[[0, 1, 0]]", R="1e-8", sigma="1e-2"
)
KORTUNOV = """\
parameters: {{g: 9.8, a: {a}}}
states: [alpha, V, R, dOm, dW]
dynamics: {{alpha: dOm, V: g*alpha + dW, R: V, dOm: a*dOm, dW: a*dW}}
measurements: {{velocity: V, position: R}}
noise: {{R: {{velocity: 0.1^2, position: 1}}, step: 1, P0_std: {{alpha: 1e-3, V: 1, R: 10, dOm: 1e-5, dW: 1e-2}}}}
"""
TURNING = """\
states: [x, y, b]
dynamics: {{x: cos(t)*y + b, y: -x/3 - y/5, b: 0}}
measurements: {{p: x, q: y + sin(t/2)*b}}
noise: {{R: {{p: 0.04, q: 0.25}}, step: 0.25, P0_std: [1, 2, 0.5]{more}}}
"""


def constant(value):
    return number(Fraction(value))


def history(given, start, stop, step=None, **options):
    return covariance_history(given, schedule_of(given, start, stop, step), forms_of(given), **options)


def at(found, t):
    k = int(np.flatnonzero(np.abs(found.t - t) < 1e-9)[0])
    return found.deviations[k], found.open_loop[k]


@pytest.mark.parametrize(
    ("text", "t", "expected"),
    [
        (GYRO, 10, [0.99304295, 0.7921662, 0.45016617]),
        (GYRO, 50, [0.99755737, 0.99252013, 0.98525833]),
        (ACCELEROMETER, 10, [0.0047759426, 0.96985153, 3.6465778e-7]),
        (ACCELEROMETER, 50, [0.095077835, 0.98540726, 8.8483422e-4]),
    ],
)
def test_the_stochastic_measure_has_the_values_of_many_digits(system, text, t, expected):
    """1 - sqrt(p+/p-) in the setting with σ = 1 m/s, 1e-3 rad, 1e-4 rad/s or 1e-2 m/s²: in 50 digits."""
    closed, opened = at(history(system(text), 0, 50), t)
    assert 1 - closed / opened == pytest.approx(expected, rel=1e-6, abs=1e-14)


@pytest.mark.parametrize(
    ("text", "t", "expected"),
    [
        (ACCELEROMETER, 1000, [0.976, 0.988, 0.950]),
        (ACCELEROMETER, 20_000, [0.99799, 0.99869, 0.99931]),
        (GYRO, 1000, [1, 1, 1]),
    ],
)
def test_beyond_the_schuler_period_all_of_it_tends_to_one(system, text, t, expected):
    closed, opened = at(history(system(text), 0, t), t)
    assert 1 - closed / opened == pytest.approx(expected, abs=5e-4 if t == 1000 else 5e-6)


@pytest.mark.parametrize(
    ("a", "expected"),
    [
        (-0.01, [0.01, 2.157e-3, 2.837e-4, 1.412e-5]),
        (0, [0.01, 7.016e-3, 6.999e-3, 6.999e-3]),
        (0.01, [0.01, 0.01549, 0.1144, 2.298]),
    ],
)
def test_the_single_channel_has_the_deviations_of_the_recomputed_paper(system, a, expected):
    found = history(system(KORTUNOV.format(a=a)), 0, 600, recorded=1000)
    assert [at(found, t)[0][4] for t in (0, 100, 300, 600)] == pytest.approx(expected, rel=3e-4)


@pytest.mark.parametrize("more", ["", ", Q: {x: 0.1, b: 0.01}", ", Q: {y: 1}"])
def test_agreement_with_the_cross_check_of_the_riccati_equation(system, more):
    given = system(TURNING.format(more=more))
    found = history(given, 0, 8, recorded=1000)
    numeric = NumericSystem(given, 0, 8)
    instants, step = samples_of(given, 0, 8)
    others = covariances(noise_model(numeric), 0, instants, step, np.diag([1.0, 2.0, 0.5]))
    ours = [at(found, t)[0] for t in (0.0, *instants)]
    assert np.array(ours) == pytest.approx(np.sqrt([np.diag(P) for P in others]), rel=1e-8)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("driven", [False, True])
def test_agreement_with_the_textbook_on_constant_systems(system, seed, driven):
    """Matrix exponential, Van Loan's integral, Joseph's update."""
    random = np.random.default_rng(seed)
    n, m = int(random.integers(1, 6)), int(random.integers(1, 4))
    A, H = random.normal(size=(n, n)) / n, random.normal(size=(m, n))
    square = random.normal(size=(n, n)) if driven else np.zeros((n, n))
    Q, R, P = square @ square.T, *(one @ one.T + np.eye(len(one)) for one in (H, A))
    text = f"states: {[f'x{i}' for i in range(n)]}\nA: {A.tolist()}\nH: {H.tolist()}\n"
    text += f"noise: {{R: {R.tolist()}, Q: {Q.tolist()}, P0: {P.tolist()}, step: 0.3}}\n".replace("'", "")
    found = history(system(text.replace("'", "")), 0, 6, recorded=1000)
    step = np.block([[-A, Q], [np.zeros((n, n)), A.T]])
    opened = P
    for k in range(21):
        if k:
            phi, noise = expm(A * 0.3), expm(step * 0.3)
            noise = phi @ noise[:n, n:]
            P, opened = (phi @ one @ phi.T + noise for one in (P, opened))
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
        P = (np.eye(n) - K @ H) @ P @ (np.eye(n) - K @ H).T + K @ R @ K.T
        closed, free = at(found, 0.3 * k)
        assert closed == pytest.approx(np.sqrt(np.diag(P)), rel=1e-9)
        assert free == pytest.approx(np.sqrt(np.diag(opened)), rel=1e-9)


def test_information_adds_up_where_nothing_drives(system, transition):
    """P(t)⁻¹ = Φ⁻ᵀ (P0⁻¹ + Σ Φᵀ Hᵀ R⁻¹ H Φ) Φ⁻¹ in a system that varies."""
    given = system(TURNING.format(more=""))
    schedule = schedule_of(given, 0, 5)
    root = roots_at(given, schedule, np.array([5.0]))[0][0]
    information = np.diag([1, 1 / 4, 4.0])
    numeric = NumericSystem(given, 0, 5)
    for t in schedule.t:
        phi = np.linalg.inv(transition(given, 0, t)[0]) if t else np.eye(3)
        rows = numeric.matrices(np.array([t]))[1][0] @ phi
        information = information + rows.T @ np.diag(1 / np.array([0.04, 0.25])) @ rows
    assert root @ root.T == pytest.approx(phi @ np.linalg.inv(information) @ phi.T, rel=1e-9)


def test_what_no_output_shows_keeps_its_prior(system):
    """No variance is negative, however much is known: 1e12 samples' worth of information beside none."""
    given = system(
        "states: [x, h]\nA: zeros(2, 2)\nH: [[1, 0]]\nnoise: {R: 1e-12, step: 0.1, P0_std: [1e6, 3]}\n"
    )
    found = history(given, 0, 100)
    assert found.deviations[:, 1] == pytest.approx(3, rel=1e-12)
    assert found.deviations[-1, 0] == pytest.approx(1e-6 / np.sqrt(1001))
    assert (np.diff(found.deviations[:, 0]) < 0).all()


def test_in_an_outage_the_covariance_is_only_propagated(system):
    """x' = w: variance grows by Q t; instants are recorded there too."""
    given = system("states: [x]\nA: [[0]]\nH: [[1]]\nnoise: {R: 1, Q: 2, P0_std: 1}\n")
    output = replace(
        given.outputs[0],
        every=constant(1),
        during=((constant(0), constant(10)), (constant(90), constant(100))),
    )
    found = history(replace(given, outputs=(output,)), 0, 100)
    gap = (found.t > 10) & (found.t < 90)
    assert gap.sum() > 20
    last = at(found, 10.0)[0][0] ** 2
    assert found.deviations[gap, 0] ** 2 == pytest.approx(last + 2 * (found.t[gap] - 10))
    assert found.samples == 22
    assert found.open_loop[:, 0] ** 2 == pytest.approx(1 + 2 * found.t)


def test_two_rates_are_the_information_of_both(system):
    given = system(
        "states: [x]\nA: [[0]]\nmeasurements: {a: x, b: x}\nnoise: {R: {a: 4, b: 9}, step: 1, P0_std: 10}\n"
    )
    slow = replace(given.outputs[1], every=constant(2.5))
    found = history(replace(given, outputs=(given.outputs[0], slow)), 0, 10)
    information = 1 / 100 + (np.floor(found.t) + 1) / 4 + (np.floor(found.t / 2.5) + 1) / 9
    assert found.deviations[:, 0] ** -2 == pytest.approx(information)


def test_a_chain_of_integrators_is_driven_at_its_end(system):
    """c' = w, b' = c, a' = b: variances q t⁵/20, q t³/3, q t of the open loop."""
    given = system(
        "states: [a, b, c]\ndynamics: {a: b, b: c, c: 0}\nmeasurements: {y: a}\n"
        "noise: {R: 1, Q: {c: 2}, step: 0.01, P0_std: [1e-9, 1e-9, 1e-9]}\n"
    )
    opened = history(given, 0, 10).open_loop[-1] ** 2
    assert opened == pytest.approx([2 * 1e5 / 20, 2 * 1e3 / 3, 20], rel=1e-12)


def test_driving_noise_may_come_and_go_between_samples(system):
    """x' = sin(50 t) w, a sample every 5 s: P = P0 + q ∫ sin²."""
    given = system(
        "states: [x]\nA: [[0]]\nG: [[sin(50*t)]]\ndisturbances: [w]\nmeasurements: {y: x}\n"
        "noise: {R: 1, Q: {w: 2}, step: 5, P0_std: [1]}\n"
    )
    found = history(given, 0, 20)
    assert found.open_loop[:, 0] ** 2 == pytest.approx(1 + found.t - np.sin(100 * found.t) / 100, rel=1e-13)


@pytest.mark.parametrize("seed", range(3))
def test_the_units_of_states_and_of_noise_do_not_matter(system, seed):
    """States in units 10^k: deviations change by 10^k, and by nothing else."""
    random = np.random.default_rng(seed)
    n = 4
    A, H, G = random.normal(size=(n, n)) / 2, random.normal(size=(2, n)), np.diag(random.uniform(0, 1, n))
    units = 10.0 ** random.integers(-8, 9, n)

    def made(scale):
        A_, H_ = A / scale * scale[:, None], H / scale
        Q, P0 = np.diag(scale**2 * np.diag(G)), scale
        return system(
            f"states: [a, b, c, d]\nA: {A_.tolist()}\nH: {H_.tolist()}\n"
            f"noise: {{R: 0.1, Q: {Q.tolist()}, P0_std: {P0.tolist()}, step: 0.2}}\n"
        )

    plain, scaled = history(made(np.ones(n)), 0, 5), history(made(units), 0, 5)
    assert scaled.deviations / units == pytest.approx(plain.deviations, rel=1e-9)


def test_correlated_outputs_are_whitened_together(system):
    given = system(
        "states: [x]\nA: [[0]]\nmeasurements: {a: x, b: x}\n"
        "noise: {R: [[2, 1], [1, 3]], step: 1, P0_std: 10}\n"
    )
    found = history(given, 0, 1)
    once = np.array([1, 1]) @ np.linalg.inv([[2, 1], [1, 3]]) @ np.array([1, 1])
    assert at(found, 0)[0][0] ** -2 == pytest.approx(0.01 + once)
    assert at(found, 1)[0][0] ** -2 == pytest.approx(0.01 + 2 * once)


def test_the_order_of_outputs_does_not_matter(system):
    given = system(TURNING.format(more=", Q: {x: 0.1}"))
    turned = system(
        TURNING.format(more=", Q: {x: 0.1}").replace("p: x, q: y + sin(t/2)*b", "q: y + sin(t/2)*b, p: x")
    )
    assert history(given, 0, 6).deviations == pytest.approx(history(turned, 0, 6).deviations, rel=1e-11)


def test_a_shift_of_time_changes_nothing_where_nothing_varies(system):
    given = system(GYRO)
    here, there = history(given, 0, 50), history(given, 1000, 1050)
    assert there.deviations == pytest.approx(here.deviations, rel=1e-9)


def test_fewer_instants_recorded_have_the_same_deviations(system):
    given = system(TURNING.format(more=", Q: {x: 0.1}"))
    many, few = history(given, 0, 20), history(given, 0, 20, recorded=7)
    assert len(few.t) == 7
    assert few.t[[0, -1]] == pytest.approx([0, 20])
    assert few.deviations == pytest.approx(many.deviations[np.isin(many.t, few.t)], rel=1e-11)


def test_quantities_and_combinations_that_vary_are_followed(system):
    text = TURNING.format(more="") + "quantities: {turned: cos(t)*x + sin(t)*y, undefined: x/t}\n"
    given = system(text)
    forms = forms_of(given, [("sum", {"x": constant(1), "y": constant(1)})])
    assert forms.names == ("x", "y", "b", "turned", "undefined", "sum")
    assert forms.kinds == ("state",) * 3 + ("quantity",) * 2 + ("combination",)
    schedule = schedule_of(given, 0, 5)
    found = covariance_history(given, schedule, forms)
    roots, opened = roots_at(given, schedule, found.t)
    for k, t in enumerate(found.t):
        rows = np.array([[np.cos(t), np.sin(t), 0], [1, 1, 0]])
        assert found.deviations[k, [3, 5]] == pytest.approx(np.linalg.norm(rows @ roots[k], axis=1))
        assert found.open_loop[k, [3, 5]] == pytest.approx(np.linalg.norm(rows @ opened[k].value, axis=1))
        assert found.open_loop[k, [3, 5]] == pytest.approx(opened[k].deviations(rows))
    assert np.isnan(found.deviations[0, 4])
    assert found.deviations[1:, 4] == pytest.approx(found.deviations[1:, 0] / found.t[1:])


def test_ins_calibration_against_plain_numpy(bundled, stage_1):
    """24 states, 16 combinations seen: information by Runge-Kutta and sums, in units of the prior."""
    given = bundled("ins_calibration/horizontal.yaml", "stage_1")
    sigma = np.array([0.01] * 3 + [1e-5] * 3 + [1e-2] * 3 + [1e-3] * 15)
    with_noise = _with_noise(given, sigma, 1e-4, 1.0)
    schedule = schedule_of(with_noise, 0, 60)
    found = covariance_history(with_noise, schedule, forms_of(with_noise))
    phi, information, steps = np.diag(sigma), np.eye(24), 20
    for k in range(61):
        if k:
            for j in range(steps):
                phi = _runge_kutta(stage_1.A, k - 1 + j / steps, 1 / steps, phi)
        rows = stage_1.H(float(k)) @ phi / 1e-4
        information = information + rows.T @ rows
    P = phi @ np.linalg.inv(information) @ phi.T
    assert found.deviations[-1] == pytest.approx(np.sqrt(np.diag(P)), rel=1e-6)


def _with_noise(given, sigma, deviation, step):
    from obscli.model.system import Matrix, Noise

    def diagonal(values):
        return Matrix(len(values), len(values), {(i, i): constant(float(v)) for i, v in enumerate(values)})

    R, P0 = diagonal([deviation**2] * given.m), diagonal(sigma**2)
    return replace(given, noise=Noise(given.states[0].place, R=R, P0=P0, step=constant(step)))


def _runge_kutta(A, t, h, phi):
    a = A(t) @ phi
    b = A(t + h / 2) @ (phi + h / 2 * a)
    c = A(t + h / 2) @ (phi + h / 2 * b)
    return phi + h / 6 * (a + 2 * b + 2 * c + A(t + h) @ (phi + h * c))


def test_an_interrupt_keeps_what_is_done(system):
    given = system(TURNING.format(more=""))
    seen = []

    def interrupted(text):
        seen.append(text)
        if len(seen) == 10:
            raise KeyboardInterrupt

    whole = history(given, 0, 30)
    found = history(given, 0, 30, progress=interrupted)
    k = len(found.t)
    assert not found.complete
    assert whole.complete
    assert 0 < k < len(whole.t)
    assert (found.deviations == whole.deviations[:k]).all()
    assert found.samples == 2 * int((schedule_of(given, 0, 30).t <= found.t[-1]).sum())
    assert seen[0].endswith(" instants, t = 0 of 30")


def test_a_state_without_prior_is_named_with_the_remedy(system):
    given = system("states: [x, y, z]\nA: zeros(3, 3)\nH: [[1, 0, 0]]\nnoise: {R: 1, P0_std: {x: 1}}\n")
    with pytest.raises(NotComputableError, match=r"y, z: give `noise: \{P0_std: \{y: …\}\}`"):
        history(given, 0, 1)


def test_a_covariance_beyond_all_numbers_is_refused_with_its_instant(system):
    given = system(
        "states: [x, y]\nA: [[1, 0], [0, 0]]\nH: [[0, 1]]\nnoise: {R: 1, step: 10, P0_std: [1, 1]}\n"
    )
    with pytest.raises(NotComputableError, match="beyond all numbers at 7"):
        history(given, 0, 2000)


@pytest.mark.parametrize("q", [0, 0.5])
@pytest.mark.parametrize("order", ["x, y", "y, x"])
def test_a_measured_instability_is_known_where_the_open_loop_is_beyond_all_numbers(system, order, q):
    """x' = x + w: P⁺ is that of the scalar Riccati equation, σ⁻² = e^2t + q (e^2t − 1)/2; y' = −y/50 keeps its own."""
    given = system(
        f"states: [{order}]\ndynamics: {{x: x, y: -y/50}}\nmeasurements: {{z: x}}\n"
        f"noise: {{R: 1, step: 0.125, P0_std: {{x: 1, y: 2}}, Q: {{x: {q}, y: 0}}}}\n"
    )
    found = history(given, 0, 1000)
    x, y = (found.names.index(name) for name in "xy")
    grown, P = np.exp(0.25), 1.0
    for _ in range(200):
        ahead = grown * P + q * (grown - 1) / 2
        P = ahead / (1 + ahead)
    assert found.deviations[-1, x] ** 2 == pytest.approx(P, rel=1e-10)
    assert found.deviations[:, y] == pytest.approx(2 * np.exp(-found.t / 50), rel=1e-10)
    assert found.open_loop[:, y] == pytest.approx(2 * np.exp(-found.t / 50), rel=1e-10)
    early = found.t < 350
    assert found.open_loop[early, x] ** 2 == pytest.approx(
        np.exp(2 * found.t[early]) * (1 + q / 2) - q / 2, rel=1e-10
    )
    assert (
        np.isinf(found.open_loop[:, x]) == (found.t + np.log1p(q / 2) / 2 > np.log(np.finfo(float).max))
    ).all()


def test_roots_are_those_after_the_sample_at_an_instant_and_between_samples(system):
    given = system("states: [x]\nA: [[0]]\nH: [[1]]\nnoise: {R: 1, step: 1, Q: 0.5, P0_std: 2}\n")
    roots, opened = roots_at(given, schedule_of(given, 0, 3), np.array([0, 0.4, 1.0, 1.0 - 1e-13]))
    P = 1 / (1 / 4 + 1)
    after = 1 / (1 / (P + 0.5) + 1)
    assert roots[:, 0, 0] ** 2 == pytest.approx([P, P + 0.2, after, after])
    assert np.array([one.value[0, 0] for one in opened]) ** 2 == pytest.approx([4, 4.2, 4.5, 4.5])
    with pytest.raises(NotComputableError, match="is not within 0 to 3"):
        roots_at(given, schedule_of(given, 0, 3), np.array([3.5]))


def test_time_to_observability_is_for_good():
    t = np.arange(5.0)
    deviations = np.array([[1, 0.05, 0.3, 0.08, 0.07], [1, 0.9, 0.8, 0.8, 0.8], [2, 1, 1, 1, 1]]).T
    prior = np.array([1.0, 1.0, 2.0])
    found = times_to_observability(
        History(("a", "b", "c"), ("state",) * 3, t, deviations, deviations, prior, 5), {"c": 1.5}
    )
    assert [one.reached for one in found] == [3.0, None, 1.0]
    assert [one.because for one in found] == ["fraction", "fraction", "require"]
    assert [one.limit for one in found] == pytest.approx([0.1, 0.1, 1.5])
