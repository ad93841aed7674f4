"""A filter designed on one model and run on another: equal models, closed forms, an independent recursion."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from scipy.linalg import expm

from obscli.model.expression import number
from obscli.numeric.errors import NotComputableError
from obscli.numeric.kalman import covariance_history
from obscli.numeric.linear_forms import forms_of
from obscli.numeric.mismatched import mismatch_history
from obscli.numeric.progress import silent
from obscli.numeric.recorded_errors import recorded_errors
from obscli.numeric.schedule import schedule_of


TURNING = """\
states: [x, y, b]
dynamics: {{x: cos(t)*y + b, y: -x/3 - y/5, b: 0}}
measurements: {{p: x, q: y + sin(t/2)*b}}
noise: {{R: {{p: 0.04, q: 0.25}}, step: 0.25, P0_std: [1, 2, 0.5]{more}}}
quantities: {{turned: cos(t)*x + sin(t)*y}}
"""
MEAN = "states: [x]\nA: [[0]]\nmeasurements: {{y: x}}\nnoise: {{R: {R}, step: {step}, P0_std: {sigma}}}\n"


def both(truth, design, start, stop, progress=silent, **options):
    true, own = (schedule_of(one, start, stop) for one in (truth, design))
    run = recorded_errors(truth, true, forms_of(design), filter_=design, filter_schedule=own, **options)
    return mismatch_history(run, progress)


@pytest.mark.parametrize("more", ["", ", Q: {x: 0.1, b: 0.01}"])
def test_equal_models_have_true_deviations_as_claimed_and_as_the_filter_has_them(system, more):
    given = system(TURNING.format(more=more))
    found = both(given, given, 0, 20)
    assert found.true == pytest.approx(found.claimed, rel=1e-9)
    alone = covariance_history(given, schedule_of(given, 0, 20), forms_of(given))
    assert found.t == pytest.approx(alone.t)
    assert found.claimed == pytest.approx(alone.deviations, rel=1e-9)
    assert (found.ignored, found.samples) == ((), alone.samples)


def test_states_in_another_order_are_matched_by_name(system):
    """And outputs: the order of either changes nothing."""
    text = TURNING.format(more=", Q: {x: 0.1, b: 0.01}")
    turned = text.replace("[x, y, b]", "[b, x, y]").replace("[1, 2, 0.5]", "[0.5, 1, 2]")
    turned = turned.replace("p: x, q: y + sin(t/2)*b", "q: y + sin(t/2)*b, p: x")
    found = both(system(text), system(turned), 0, 6)
    assert found.names == ("b", "x", "y", "turned")
    assert found.true == pytest.approx(found.claimed, rel=1e-9)


def test_a_mean_with_the_wrong_noise(system):
    """Weights of the filter on a constant: claimed 1/(1/s² + k/r), true from the weights themselves."""
    truth, design = system(MEAN.format(R=9, step=1, sigma=2)), system(MEAN.format(R=1, step=1, sigma=5))
    found = both(truth, design, 0, 10, recorded=100)
    k = np.floor(found.t + 1e-9) + 1
    information = 1 / 25 + k
    assert found.claimed[:, 0] == pytest.approx(information**-0.5)
    true = (1 / 25 / information) ** 2 * 4 + k * 9 / information**2
    assert found.true[:, 0] == pytest.approx(np.sqrt(true))


def test_a_filter_that_takes_every_third_sample_is_right_about_itself(system):
    truth, design = system(MEAN.format(R=9, step=1, sigma=2)), system(MEAN.format(R=9, step=3, sigma=2))
    found = both(truth, design, 0, 12)
    assert found.true == pytest.approx(found.claimed, rel=1e-12)
    assert found.samples == 5


def test_an_ignored_drift_makes_the_filter_optimistic(system):
    """b measured as x + b t: a filter without b sees a mean, its error grows with the drift."""
    truth = system(
        "states: [x, b]\ndynamics: {x: b, b: 0}\nmeasurements: {y: x}\n"
        "noise: {R: 1, step: 1, P0_std: [2, 3]}\n"
    )
    design = system(MEAN.format(R=1, step=1, sigma=2))
    found = both(truth, design, 0, 20)
    assert found.ignored == ("b",)
    ends = found.t == 20
    weights = np.full(21, 1 / (1 / 4 + 21))
    gain = 20 - weights @ np.arange(21.0)
    true = (1 - weights.sum()) ** 2 * 4 + weights @ weights + gain**2 * 9
    assert found.true[ends, 0] ** 2 == pytest.approx(true)
    assert found.claimed[ends, 0] ** 2 == pytest.approx(1 / (1 / 4 + 21))


def test_a_state_that_the_truth_does_not_have_is_zero_there(system):
    truth = system(MEAN.format(R=1, step=1, sigma=2))
    design = system(
        "states: [x, b]\ndynamics: {x: b, b: 0}\nmeasurements: {y: x}\n"
        "noise: {R: 1, step: 1, P0_std: [2, 3]}\n"
    )
    found = both(truth, design, 0, 20)
    assert found.true[found.t == 20, 1] < found.claimed[found.t == 20, 1]
    assert (found.true[:, 1] <= 3).all()


@pytest.mark.parametrize("seed", range(5))
def test_agreement_with_the_covariance_of_truth_and_estimate_stacked(system, seed):
    """(x, x̂) together: x = Φ x + w, x̂ = Φ_f x̂, x̂⁺ = x̂ + K (H x + v − H_f x̂), by expm; e = E x − x̂."""
    random = np.random.default_rng(seed)
    n, n_f, m, step = 4, 3, 2, 0.4
    A, H, R, Q, P = _random_model(random, n, m)
    A_f, H_f, R_f, Q_f, P_f = _random_model(random, n_f, m)
    found = both(
        system(_text(n, A, H, R, Q, P, step)), system(_text(n_f, A_f, H_f, R_f, Q_f, P_f, step)), 0, 6
    )
    phi, noise = _discrete(A, Q, step)
    phi_f, noise_f = _discrete(A_f, Q_f, step)
    E = np.eye(n_f, n)
    whole = np.zeros((n + n_f, n + n_f))
    whole[:n, :n] = P
    for k in range(16):
        if k:
            F = np.block([[phi, np.zeros((n, n_f))], [np.zeros((n_f, n)), phi_f]])
            whole = F @ whole @ F.T
            whole[:n, :n] += noise
            P_f = phi_f @ P_f @ phi_f.T + noise_f
        K = P_f @ H_f.T @ np.linalg.inv(H_f @ P_f @ H_f.T + R_f)
        P_f = (np.eye(n_f) - K @ H_f) @ P_f
        F = np.block([[np.eye(n), np.zeros((n, n_f))], [K @ H, np.eye(n_f) - K @ H_f]])
        whole = F @ whole @ F.T
        whole[n:, n:] += K @ R @ K.T
        e = np.hstack([E, -np.eye(n_f)])
        at = np.abs(found.t - k * step) < 1e-9
        assert found.claimed[at][0] ** 2 == pytest.approx(np.diag(P_f), rel=1e-7)
        assert found.true[at][0] ** 2 == pytest.approx(np.diag(e @ whole @ e.T), rel=1e-7)


def _random_model(random, n, m):
    def definite(k):
        square = random.normal(size=(k, k))
        return square @ square.T + np.eye(k) / 2

    return random.normal(size=(n, n)) / n, random.normal(size=(m, n)), definite(m), definite(n), definite(n)


def _text(n, A, H, R, Q, P, step):
    names = ", ".join(f"x{i}" for i in range(n))
    noise = f"{{R: {R.tolist()}, Q: {Q.tolist()}, P0: {P.tolist()}, step: {step}}}"
    return f"states: [{names}]\nA: {A.tolist()}\nH: {H.tolist()}\nnoise: {noise}\n"


def _discrete(A, Q, step):
    n = len(A)
    phi = expm(A * step)
    block = expm(np.block([[-A, Q], [np.zeros((n, n)), A.T]]) * step)
    return phi, phi @ block[:n, n:]


def test_an_interrupt_keeps_what_is_done(system):
    given = system(TURNING.format(more=""))
    seen = []

    def interrupted(text):
        seen.append(text)
        if len(seen) == 10:
            raise KeyboardInterrupt

    found, whole = both(given, given, 0, 30, progress=interrupted), both(given, given, 0, 30)
    assert (found.complete, whole.complete) == (False, True)
    assert 0 < len(found.t) < len(whole.t)
    assert (found.true == whole.true[: len(found.t)]).all()


@pytest.mark.parametrize(
    ("design", "reason"),
    [
        (MEAN.format(R=1, step=0.5, sigma=2), "a sample of y at 0.5, but the true model has none"),
        (MEAN.format(R=1, step=1, sigma=2).replace("y: x", "z: x"), "has no output z"),
        (
            MEAN.format(R=1, step=1, sigma=2).replace("[[0]]", "[[a]]") + "functions: [a, c]\n",
            "not move alike",
        ),
    ],
)
def test_what_does_not_fit_together_is_refused(system, design, reason):
    truth = system(
        MEAN.format(R=1, step=1, sigma=2).replace("[[0]]", "[[a + c]]") + "functions: [c, a]\n"
        if "functions" in design
        else MEAN.format(R=1, step=1, sigma=2)
    )
    with pytest.raises(NotComputableError, match=reason):
        both(truth, system(design), 0, 10)


def test_a_filter_may_not_use_an_output_in_an_outage_of_the_truth(system):
    given = system(MEAN.format(R=1, step=1, sigma=2))
    some = (replace(given.outputs[0], every=number(1), during=((number(0), number(Fraction(4))),)),)
    with pytest.raises(NotComputableError, match="a sample of y at 5"):
        both(replace(given, outputs=some), given, 0, 10)
    assert both(given, replace(given, outputs=some), 0, 10).samples == 5


def test_both_start_at_the_same_time(system):
    given = system(MEAN.format(R=1, step=1, sigma=2))
    schedules = schedule_of(given, 0, 10), schedule_of(given, 5, 10)
    with pytest.raises(NotComputableError, match="starts at 5, the true model at 0"):
        recorded_errors(given, schedules[0], forms_of(given), filter_=given, filter_schedule=schedules[1])
