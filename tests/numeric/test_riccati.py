"""The Riccati equation from two priors: against closed forms, and what it says of detectability."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigh

from obscli.model.reader import read_text
from obscli.numeric.errors import NotComputableError
from obscli.numeric.riccati import cross_check


CHANNEL = """\
parameters: {{g: 9.8, a: {a}}}
states: [alpha, V, R, dOm, dW]
dynamics: {{alpha: dOm, V: g*alpha + dW, R: V, dOm: a*dOm, dW: a*dW}}
measurements: {{velocity: V, position: R}}
noise: {{R: {{velocity: 0.1^2, position: 1}}, step: 1, P0_std: {{alpha: 1e-3, V: 1, R: 10, dOm: 1e-5, dW: 1e-2}}}}
"""


def checked(text, start, stop):
    return cross_check(read_text(text, "test.yaml").systems[0], start, stop)


@pytest.mark.parametrize(
    ("a", "expected"),
    [
        (-0.01, [0.01, 2.157e-3, 2.837e-4, 1.412e-5]),
        (0, [0.01, 7.016e-3, 6.999e-3, 6.999e-3]),
        (0.01, [0.01, 0.01549, 0.1144, 2.298]),
    ],
)
def test_the_deviation_of_the_accelerometer_error_is_that_of_the_recomputed_paper(a, expected):
    """Kortunov & Proskura 2006, single channel with equal rates: at 0, 100, 300 and 600 s."""
    found = checked(CHANNEL.format(a=a), 0, 600)
    shown = [found.deviations["dW"][found.instants.index(t)] for t in (0, 100, 300, 600)]
    assert shown == pytest.approx(expected, rel=3e-4)
    assert found.apart[-1] == pytest.approx(np.exp(600 * a), rel=1e-2)


def test_a_measured_constant_has_the_variance_of_its_mean():
    """1/P = 1/P0 + k/R, whatever the prior; the two end together."""
    found = checked("states: [x]\nA: [[0]]\nH: [[1]]\nnoise: {R: 4, step: 0.5, P0_std: 3}\n", 0, 30)
    k = 1 + np.array(found.instants) / 0.5
    assert found.deviations["x"] == pytest.approx(1 / np.sqrt(1 / 9 + k / 4))
    assert found.wider["x"] == pytest.approx(1 / np.sqrt(1 / 36 + k / 4))
    assert found.apart[-1] < 0.02


def test_driving_noise_ends_in_the_stationary_variance():
    """x' = -x + w, hidden behind nothing: P → Q/2 unmeasured; measured less; both priors end alike."""
    text = "states: [x, y]\ndynamics: {{x: -x, y: -y}}\nmeasurements: {{z: {z}}}\nnoise: {{R: 1, Q: {{x: 2}}, P0_std: 1}}\n"
    hidden = checked(text.format(z="y"), 0, 20)
    assert hidden.deviations["x"][-1] == pytest.approx(1.0, rel=1e-3)
    assert hidden.apart[-1] < 1e-6
    seen = checked(text.format(z="x"), 0, 20)
    assert seen.deviations["x"][-1] == pytest.approx(np.sqrt(np.sqrt(3) - 1), rel=2e-2)  # 0 = -2P + 2 - P²


def test_without_process_noise_information_adds_up():
    """P(t)⁻¹ = Φ⁻ᵀ (P0⁻¹ + W) Φ⁻¹ with W the sum over the samples."""
    text = (
        "states: [p, v]\nA: [[0, 1], [0, 0]]\nH: [[1, 0]]\nnoise: {R: 0.25, step: 1, P0_std: {p: 2, v: 3}}\n"
    )
    found = checked(text, 0, 12)
    for k, t in enumerate(found.instants):
        W = sum(np.array([[1, s], [s, s * s]]) / 0.25 for s in range(round(t) + 1))
        phi = np.array([[1, t], [0, 1]])
        P = phi @ np.linalg.inv(np.diag([1 / 4, 1 / 9]) + W) @ phi.T
        assert [found.deviations[s][k] for s in ("p", "v")] == pytest.approx(np.sqrt(np.diag(P)))


@pytest.mark.parametrize(("rate", "ends"), [("-1", 0.0), ("0", 1.0)])
def test_the_two_end_alike_exactly_if_what_is_hidden_dies_out(rate, ends):
    text = f"states: [x, h]\ndynamics: {{x: -x, h: ({rate})*h}}\nmeasurements: {{y: x}}\nnoise: {{R: 1, P0_std: 1}}\n"
    assert checked(text, 0, 30).apart[-1] == pytest.approx(ends, abs=1e-6)


def test_states_without_a_prior_are_named():
    text = (
        "states: {x: {scale: 5}, h: {scale: 7}}\nA: zeros(2, 2)\nH: [[1, 0]]\nnoise: {R: 1, P0_std: {x: 2}}\n"
    )
    found = checked(text, 0, 1)
    assert found.assumed == ("h",)
    assert found.deviations["h"][0] == pytest.approx(7)


@pytest.mark.parametrize(
    ("noise", "reason"),
    [("", "the file has no `noise`"), ("noise: {R: 1, step: 1e-9}\n", "samples on the interval")],
)
def test_what_cannot_be_checked_is_said(noise, reason):
    with pytest.raises(NotComputableError, match=reason):
        checked(f"states: [x]\nA: [[0]]\nH: [[1]]\n{noise}", 0, 1)


@pytest.mark.parametrize("step", [0.1, 1, 3, 20])
def test_driving_noise_does_not_depend_on_the_steps(step):
    """P' = -2P + 2 + ... of x' = -x + w, unmeasured, from 4: P = 1 + 3 e^(-2t); and a drive that varies."""
    text = (
        "states: [x, z, y]\ndynamics: {x: -x, z: -3*z, y: -y}\nmeasurements: {m: y}\n"
        "G: [[1, 0], [0, sin(5*t)], [0, 0]]\n"
        f"noise: {{R: 1, Q: [[2, 0], [0, 6]], P0_std: 2, step: {step}}}\n"
    )
    found = checked(text, 0, 40)
    t = np.array(found.instants)
    assert np.square(found.deviations["x"]) == pytest.approx(1 + 3 * np.exp(-2 * t), rel=1e-5)
    driven = 0.5 - (6 * np.cos(10 * t) + 10 * np.sin(10 * t)) * 3 / 136
    expected = driven + (4 - driven[0]) * np.exp(-6 * t)
    assert np.square(found.deviations["z"]) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("seed", range(6))
def test_the_two_never_come_closer_than_hidden_errors_shrink(seed):
    """P4 - P1 >= 3 Phi n n' Phi', whatever R, Q and the correlations of P0."""
    source = np.random.default_rng(seed)
    root = source.normal(size=(3, 3))
    P0, Q = root @ root.T, np.diag(source.uniform(0, 1, 3)) * (seed % 2)
    text = (
        "states: [y, a, b]\ndynamics: {y: -y, a: -a/5 + sin(t)*b + y, b: a/9}\nmeasurements: {z: y}\n"
        f"noise: {{R: 0.3, Q: {Q.tolist()}, P0: {((P0 + P0.T) / 2).tolist()}, step: 0.25}}\n"
    )
    found = checked(text, 0, 6)
    metric = np.linalg.inv(P0)[1:, 1:]  # lengths of what is hidden, n P0⁻¹ n
    after = solve_ivp(
        lambda t, x: (np.array([[-0.2, np.sin(t)], [1 / 9, 0]]) @ x.reshape(2, 2)).ravel(),
        (0, 6), np.eye(2).ravel(), t_eval=found.instants, rtol=1e-10, atol=1e-12,
    ).y.T.reshape(-1, 2, 2)  # fmt: skip
    for phi, apart in zip(after[1:], found.apart[1:], strict=True):
        assert apart >= np.sqrt(eigh(phi.T @ metric @ phi, metric, eigvals_only=True)[-1]) * (1 - 1e-6)


def test_covariances_beyond_all_numbers_are_refused():
    text = "states: [x, y]\ndynamics: {x: 5*x, y: -y}\nmeasurements: {z: y}\nnoise: {R: 1, P0_std: 1}\n"
    with pytest.raises(NotComputableError, match="beyond all numbers"):
        checked(text, 0, 600)
