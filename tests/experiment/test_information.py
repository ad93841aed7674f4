"""What measurements with noise tell: against the Riccati equation, and the laws of adding up."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from obscli.numeric.information import information


# -- three small systems, in the file's words and by hand

DECAY = (
    "states: [x, c]\ndynamics: {x: -x + c}\nmeasurements: {y: x}\n",
    lambda _: np.array([[-1.0, 1.0], [0.0, 0.0]]),
    lambda _: np.array([[1.0, 0.0]]),
    "{x: 0.5}", lambda _: np.diag([0.5, 0.0]),
    "0.2", np.array([[0.2]]),
)  # fmt: skip
OSCILLATOR = (
    "states: [p, v, b]\ndynamics: {p: v, v: -4*p - 0.3*v}\nmeasurements: {y: p + b, z: v}\n",
    lambda _: np.array([[0.0, 1.0, 0.0], [-4.0, -0.3, 0.0], [0.0, 0.0, 0.0]]),
    lambda _: np.array([[1.0, 0.0, 1.0], [0.0, 1.0, 0.0]]),
    "{v: 0.1}", lambda _: np.diag([0.0, 0.1, 0.0]),
    "[[1, 0.3], [0.3, 2]]", np.array([[1.0, 0.3], [0.3, 2.0]]),
)  # fmt: skip
MODULATED = (
    ("states: [x, c, d]\ndisturbances: [w]\ndynamics: {x: cos(t)*c + d + (1 + t/4)*w}\n"
    "measurements: {y: x/(1 + t)}\n"),
    lambda t: np.array([[0.0, np.cos(t), 1.0], [0.0] * 3, [0.0] * 3]),
    lambda t: np.array([[1 / (1 + t), 0.0, 0.0]]),
    "{w: 0.3}", lambda t: np.diag([0.3 * (1 + t / 4) ** 2, 0.0, 0.0]),
    "0.05", np.array([[0.05]]),
)  # fmt: skip
SYSTEMS = {"decay": DECAY, "oscillator": OSCILLATOR, "modulated": MODULATED}
INSTANTS = np.array([2.0, 5.0, 10.0])


def riccati(system, Y0, driven):
    """Y' = −AᵀY − YA − Y G Q Gᵀ Y + Hᵀ R⁻¹ H at the instants."""
    _, A, H, _, Q, _, R = system
    n, weight = len(Y0), np.linalg.inv(R)

    def rate(t, y):
        Y = y.reshape(n, n)
        a, h = A(t), H(t)
        loss = Y @ Q(t) @ Y if driven else 0.0
        return (-a.T @ Y - Y @ a - loss + h.T @ weight @ h).ravel()

    found = solve_ivp(
        rate, (0, INSTANTS[-1]), Y0.ravel(), method="DOP853", rtol=1e-12, atol=1e-14, t_eval=INSTANTS
    )
    return found.y.T.reshape(-1, n, n)


def deviations_of(Y):
    return np.sqrt(np.diag(np.linalg.inv(Y)))


def found_by(noise, system, prior, driven, kept=None):
    """Roots of information on some states, with the model's own prior."""
    text, _, _, Q, _, R, _ = system
    q = f", Q: {Q}" if driven else ""
    model = noise(text + f"noise: {{R: {R}{q}{prior}}}\n", INSTANTS[-1])
    n = model.system.n
    kept = np.arange(n) if kept is None else np.array(kept)
    return information(model, 0.0, INSTANTS, kept, model.prior()), model.prior()


FULL = {
    "decay": ", P0_std: {x: 1, c: 2}",
    "oscillator": ", P0: [[1, 0.2, 0], [0.2, 2, 0.1], [0, 0.1, 3]]",
    "modulated": ", P0_std: {x: 1, c: 2, d: 0.5}",
}
PARTIAL = {"decay": ", P0_std: {x: 1}", "oscillator": ", P0_std: {b: 3}", "modulated": ", P0_std: {c: 1}"}
PRIORS = {"full": FULL, "partial": PARTIAL, "none": dict.fromkeys(SYSTEMS, "")}


@pytest.mark.parametrize("driven", [False, True])
@pytest.mark.parametrize("prior", PRIORS)
@pytest.mark.parametrize("name", SYSTEMS)
def test_it_solves_the_riccati_equation(noise, name, prior, driven):
    roots, U = found_by(noise, SYSTEMS[name], PRIORS[prior][name], driven)
    expected = riccati(SYSTEMS[name], U.T @ U, driven)
    for S, Y in zip(roots, expected, strict=True):
        np.testing.assert_allclose(deviations_of(S.T @ S), deviations_of(Y), rtol=1e-2 if driven else 1e-8)


@pytest.mark.parametrize("driven", [False, True])
@pytest.mark.parametrize("prior", PRIORS)
@pytest.mark.parametrize(
    ("name", "kept"), [("decay", [1]), ("oscillator", [2]), ("oscillator", [0, 2]), ("modulated", [1, 2])]
)
def test_the_others_are_eliminated(noise, name, kept, prior, driven):
    """The information on some states is what is left of their covariance when the others are unknown."""
    roots, U = found_by(noise, SYSTEMS[name], PRIORS[prior][name], driven, kept)
    expected = riccati(SYSTEMS[name], U.T @ U, driven)
    for S, Y in zip(roots, expected, strict=True):
        assert S.shape == (len(kept), len(kept))
        np.testing.assert_allclose(
            deviations_of(S.T @ S), deviations_of(Y)[kept], rtol=1e-2 if driven else 1e-8
        )


@pytest.mark.parametrize("name", SYSTEMS)
def test_driving_noise_takes_information_away(noise, name):
    still, _ = found_by(noise, SYSTEMS[name], FULL[name], driven=False)
    driven, _ = found_by(noise, SYSTEMS[name], FULL[name], driven=True)
    for S, T in zip(still, driven, strict=True):
        assert np.linalg.eigvalsh(S.T @ S - T.T @ T).min() > -1e-9 * np.linalg.norm(S) ** 2


def test_a_random_walk_settles_where_noise_and_drift_balance(noise):
    """x' = w, y = x + v: P = √(Q R) in the end."""
    model = noise("states: [x]\ndynamics: {}\nmeasurements: {y: x}\nnoise: {R: 4, Q: {x: 9}}\n", 20.0)
    [S] = information(model, 0.0, np.array([20.0]), np.array([0]), model.prior())
    assert S[0, 0] ** -2 == pytest.approx(6, rel=1e-2)


@pytest.mark.parametrize("R", [1.0, 1e-2, 1e-4])
def test_the_result_stands_however_fast_the_filter_is(noise, R):
    text = (
        f"states: [x, c]\ndynamics: {{x: -x + c}}\nmeasurements: {{y: x}}\nnoise: {{Q: {{x: 1}}, R: {R}}}\n"
    )
    model = noise(text, 10.0)
    roots = information(model, 0.0, INSTANTS, np.array([1]), model.prior())
    system = (*DECAY[:3], "", lambda _: np.diag([1.0, 0.0]), "", np.array([[R]]))
    expected = riccati(system, np.zeros((2, 2)), driven=True)
    for S, Y in zip(roots, expected, strict=True):
        np.testing.assert_allclose(deviations_of(S.T @ S), deviations_of(Y)[[1]], rtol=1e-2)


# -- samples, units


@pytest.mark.parametrize("name", SYSTEMS)
def test_a_covariance_per_sample_is_a_density_times_the_step(noise, name):
    text, *_ = SYSTEMS[name]
    one, other = (
        noise(text + f"noise: {{R: {R}{step}{FULL[name]}}}\n", 10.0)
        for R, step in (("3", ""), ("12", ", step: 1/4"))
    )
    kept = np.arange(one.system.n)
    for S, T in zip(
        *(information(one_, 0.0, INSTANTS, kept, one_.prior()) for one_ in (one, other)), strict=True
    ):
        np.testing.assert_allclose(T.T @ T, S.T @ S, rtol=1e-12)


def test_a_step_of_the_filter_is_what_the_density_stands_for(noise):
    """A constant measured 40 times with 2: 2/√40, whether in samples 1/4 s apart or as a density of 1."""
    text = "states: [c]\ndynamics: {}\nmeasurements: {y: c}\nnoise: {R: 4, step: 1/4}\n"
    model = noise(text, 10.0)
    [S] = information(model, 0.0, np.array([10.0]), np.array([0]), model.prior())
    assert 1 / abs(S[0, 0]) == pytest.approx(2 / 40**0.5, rel=1e-10)


@pytest.mark.parametrize("driven", [False, True])
def test_units_by_powers_of_two_change_nothing(noise, driven):
    """c in units of 2^-7, x of 2^9, y of 2^5: the information is in these units, and otherwise the same."""
    q = ", Q: {x: 0.5}" if driven else ""
    plain = noise(f"{DECAY[0]}noise: {{R: 0.2{q}, P0_std: {{x: 1, c: 2}}}}\n", 10.0)
    q = ", Q: {x: 0.5/2^18}" if driven else ""
    scaled = noise(
        "states: [x, c]\ndynamics: {x: -x + c*2^-16}\nmeasurements: {y: x*2^14}\n"
        f"noise: {{R: 0.2*2^10{q}, P0_std: {{x: 1/2^9, c: 2*2^7}}}}\n",
        10.0,
    )
    for S, T in zip(
        *(information(one, 0.0, INSTANTS, np.arange(2), one.prior()) for one in (plain, scaled)), strict=True
    ):
        units = np.array([2.0**9, 2.0**-7])
        np.testing.assert_allclose(T.T @ T / units / units[:, None], S.T @ S, rtol=1e-9)


# -- adding up


def test_what_is_constant_adds_up_over_time(noise):
    """x' = 0: the information of [0, 10] is that of [0, 4] and of [4, 10]."""
    text = (
        "states: [a, b]\ndynamics: {}\nmeasurements: {y: a + sin(t)*b, z: exp(-t)*a - b}\n"
        "noise: {R: {y: 1, z: 4}}\n"
    )
    model, kept, none = noise(text, 10.0), np.arange(2), np.zeros((0, 2))

    def told(start, stop):
        [S] = information(model, start, np.array([stop]), kept, none)
        return S.T @ S

    np.testing.assert_allclose(told(0.0, 4.0) + told(4.0, 10.0), told(0.0, 10.0), rtol=1e-10)


RUNS = """\
states: [x, a, b]
parameters: {w: 2}
dynamics: {x: -x + a}
measurements: {y: x + w*b, z: a - b}
noise: {R: {y: 1, z: 9}, Q: {x: 0.1}, P0_std: {x: 1, a: 5, b: 7}}
interval: {stop: 20}
experiment:
  runs: [{name: one}, {name: back, fix: {w: -w}}, {name: still, fix: {w: 0}, interval: {stop: 5}}]
"""


def information_of(told, runs):
    """P⁻¹ after some runs: of the prior and of each at its end."""
    parts = [told.prior, *(told.runs[k].roots[-1] for k in runs)]
    return sum(part.T @ part for part in parts)


def test_information_of_runs_and_prior_adds_up(calibrated, told):
    found, all_told = calibrated(RUNS).accuracy, told(RUNS)
    for runs in ([0], [0, 1], [0, 1, 2]):
        expected = deviations_of(information_of(all_told, runs))
        np.testing.assert_allclose([one.runs[len(runs) - 1] for one in found.states], expected, rtol=1e-9)
    for k in range(3):
        expected = deviations_of(information_of(all_told, [k]))
        np.testing.assert_allclose([one.alone[k] for one in found.states], expected, rtol=1e-9)
    assert [one.before for one in found.states] == [5, 7]


def test_the_order_of_runs_does_not_matter_in_the_end(calibrated):
    first, *rest = RUNS.split("[{name: one}")
    swapped = (
        first + "[{name: still, fix: {w: 0}, interval: {stop: 5}}, {name: back, fix: {w: -w}}, {name: one}]\n"
    )
    assert rest
    one, other = (calibrated(text).accuracy for text in (RUNS, swapped))
    for mine, theirs in zip(one.states, other.states, strict=True):
        assert mine.after == pytest.approx(theirs.after, rel=1e-10)
        assert mine.alone == pytest.approx(theirs.alone[::-1], rel=1e-10)


def test_deviations_never_grow_over_the_runs(calibrated):
    found = calibrated(RUNS).accuracy
    for one, values in zip(found.states, found.history.values, strict=True):
        assert all(np.diff(values) <= 1e-9 * one.before)
        assert (values[0], values[-1]) == (one.before, pytest.approx(one.after))
    assert found.history.ends == (20, 40, 45)
    assert list(found.history.times) == sorted(found.history.times)


@pytest.mark.parametrize("seed", range(0, 20, 2))
def test_a_run_done_twice_halves_the_variance_of_what_it_determines(known, calibrated, seed):
    """White noise, no prior, driven fresh states or not; what it does not determine stays infinite."""
    experiment = known.build(seed)
    alone = 0
    for run in experiment.runs:
        text = experiment.text(
            [run], "noise: {R: 0.01, Q: {x1: 0.001}}\n", lambda run: f"{{stage: {run.name}, repeat: 2}}"
        )
        found = calibrated(text)
        if found.accuracy is None:
            assert "dimly" in found.no_accuracy or "resolved" in found.no_accuracy
            continue
        verdicts = found.exact.stack.finding.states
        for one in found.accuracy.states:
            once, twice = one.runs
            assert np.isfinite(once) == (verdicts[one.name] == "observable"), one.name
            if np.isfinite(once):
                alone += 1
                assert twice == pytest.approx(once / 2**0.5, rel=1e-6)
            else:
                assert twice == np.inf
    assert alone or not any(
        known.rank([*run.rows, unit]) == known.rank(run.rows)
        for run in experiment.runs
        for unit in ([int(j == k) for j in range(experiment.p)] for k in range(experiment.p))
    )


def finite_and_determined(known, calibrated, seed):
    """The states with a finite deviation where there is no prior, and those that are determined."""
    experiment = known.build(seed)
    found = calibrated(experiment.text(more="noise: {R: 0.01}\n"))
    assert found.accuracy is not None, found.no_accuracy
    finite = {one.name for one in found.accuracy.states if np.isfinite(one.after)}
    return finite, set(experiment.determined())


@pytest.mark.parametrize("seed", range(0, 60, 3))
def test_what_is_not_determined_stays_infinite(known, calibrated, seed):
    finite, determined = finite_and_determined(known, calibrated, seed)
    assert finite <= determined


def test_what_is_determined_is_finite(known, calibrated):
    for seed in (26, 30, 36, 56, 58):
        finite, determined = finite_and_determined(known, calibrated, seed)
        assert finite >= determined, seed


def test_what_is_measured_by_itself_is_as_good_as_its_noise(calibrated):
    found = calibrated(
        "states: [a, b, c, d]\ndynamics: {}\nmeasurements: {y: 2*c - a - d, z: -a}\nnoise: {R: 1}\n"
        "interval: {stop: 1}\nexperiment: {runs: [{name: one}]}\n"
    )
    assert found.exact.stack.finding.states["a"] == "observable"
    assert found.accuracy.states[0].after == pytest.approx(1)


def test_a_quantity_measured_by_itself_is_as_good_as_its_noise(calibrated):
    """0.67 is printed, and the requirement called met."""
    found = calibrated(
        "states: [a, b, c, d, e]\ndynamics: {}\nmeasurements: {y: 2*b + c}\nnoise: {R: 1}\n"
        "quantities: {q: 2*b + c}\nrequire: {q: 0.9}\ninterval: {stop: 1}\n"
        "experiment: {runs: [{name: one}]}\n"
    )
    assert found.accuracy.required[0].after == pytest.approx(1)
    assert found.failed == 1


DECAYING = """\
states: [x, c]
dynamics: {{x: c - x}}
measurements: {{y: x}}
noise: {{R: 1, P0_std: {{x: 1}}}}
interval: {{stop: {stop}}}
experiment: {{runs: [{{name: one}}]}}
"""


def closed_form(stop):
    """y = c (1 − e^−t) + x0 e^−t with R = 1 and x0 known to 1: the deviation of c after some time."""
    fading, twice = 1 - np.exp(-stop), (1 - np.exp(-2 * stop)) / 2
    seen, mixed, start = stop - 2 * fading + twice, fading - twice, 1 + twice
    return (seen - mixed**2 / start) ** -0.5


@pytest.mark.parametrize("stop", [1, 10, 25])
def test_a_fresh_state_that_decays_takes_its_beginning_along(calibrated, stop):
    [c] = calibrated(DECAYING.format(stop=stop)).accuracy.states
    assert c.after == pytest.approx(closed_form(stop), rel=1e-4)


@pytest.mark.parametrize("stop", [40, 100])
def test_what_is_lost_because_a_fresh_state_has_decayed_is_told(calibrated, stop):
    accuracy = calibrated(DECAYING.format(stop=stop)).accuracy
    assert accuracy.states[0].after == np.inf
    assert any("of c is lost to rounding" in note for note in accuracy.notes)


@pytest.mark.parametrize("stop", [400, 1000])
def test_a_state_that_has_decayed_too_far_is_told(calibrated, stop):
    found = calibrated(DECAYING.format(stop=stop))
    assert found.accuracy is None
    assert "decays too far" in found.no_accuracy


@pytest.mark.parametrize("factor", [3, 0.7])
def test_driving_noise_is_resolved_beside_a_state_that_the_run_does_not_show(noise, factor):
    """y = x + 3 b: b cannot be told from where x begins; nothing of it is left, but rounding."""
    text = (
        f"states: [x, a, b]\ndynamics: {{x: a}}\nmeasurements: {{y: x + {factor}*b}}\n"
        "noise: {R: 0.01, Q: {x: 0.01}}\n"
    )
    model = noise(text, 10.0)
    roots = information(model, 0.0, INSTANTS, np.array([1, 2]), model.prior())
    system = (
        "", lambda _t: np.array([[0.0, 1.0], [0.0, 0.0]]), lambda _t: np.array([[1.0, 0.0]]),
        "", lambda _t: np.diag([0.01, 0.0]), "", np.array([[0.01]]),
    )  # fmt: skip
    for S, Y in zip(roots, riccati(system, np.zeros((2, 2)), driven=True), strict=True):
        assert np.linalg.norm(S[:, 0]) ** -1 == pytest.approx(deviations_of(Y)[1], rel=1e-2)
        assert np.abs(S[:, 1]).max() < 1e-9 * np.abs(S[:, 0]).max()
