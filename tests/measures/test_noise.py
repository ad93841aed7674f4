"""Measures from the noise: against recomputed numbers, closed forms, and the information form of the filter."""

import numpy as np
import pytest
from scipy.linalg import expm


def noisy(which, *, prior, sigma, extra=""):
    """Return one of Bagmut's systems with the setting R1 of the digest: P0, σ_z, one sample a second."""
    A, H, third = {
        "gyro": ("[[0, -9.8, 0], [1/6378137, 0, 1], [0, 0, 0]]", "[[1, 0, 0]]", "domega"),
        "accelerometer": ("[[0, -9.8, 1], [1/6378137, 0, 0], [0, 0, 0]]", "[[0, 1, 0]]", "da"),
    }[which]
    noise = f"{{R: {sigma}^2, step: 1, P0_std: [{', '.join(map(str, prior))}]}}"
    return f"states: [dv, alpha, {third}]\nA: {A}\nH: {H}\nnoise: {noise}\n{extra}"


GYRO = noisy("gyro", prior=(1, "1e-3", "1e-4"), sigma="0.01")
ACCELEROMETER = noisy("accelerometer", prior=(1, "1e-3", "1e-2"), sigma="1e-4")


@pytest.mark.parametrize(
    ("text", "t", "expected"),
    [
        (GYRO, 10, (0.99304295, 0.7921662, 0.45016617)),
        (GYRO, 50, (0.99755737, 0.99252013, 0.98525833)),
        (ACCELEROMETER, 10, (0.0047759426, 0.96985153, 3.6465778e-7)),
        (ACCELEROMETER, 50, (0.095077835, 0.98540726, 8.8483422e-4)),
    ],
)
def test_the_stochastic_measure_of_setting_r1(measure, text, t, expected):
    found = measure(text, stop=str(t), select=("stochastic",))
    assert found.state("stochastic") == pytest.approx(expected, rel=1e-6)


def test_everything_is_learned_in_the_end_where_all_is_observable(measure):
    """With Q = 0 every μ goes to 1 in both systems: which states are good is a matter of the horizon."""
    found = measure(ACCELEROMETER, stop="20000", select=("stochastic",))
    assert found.state("stochastic") == pytest.approx((0.99799, 0.99869, 0.99931), abs=2e-5)


def test_a_state_that_is_not_observable_does_not_get_zero(measure):
    """R = ∞ hides dv exactly, and still its prior deviation shrinks against the open loop."""
    A, H = "[[0, -9.8, 1], [0, 0, 0], [0, 0, 0]]", "[[0, 1, 0]]"
    text = f"states: [dv, alpha, da]\nA: {A}\nH: {H}\nnoise: {{R: 1e-8, step: 1, P0_std: [1, 1e-3, 1e-2]}}\n"
    found = measure(text, stop="50")
    assert found.state("stochastic")[0] == pytest.approx(0.0841, abs=5e-5)
    assert [one.observable for one in found.subject.targets[:3]] == [False, True, False]
    assert found.state("cramer-rao")[0] == np.inf
    assert found.state("cramer-rao")[2] == np.inf


def test_the_prior_of_the_tilt_and_the_bias_decides_what_is_left_of_the_bias(measure):
    """full4, H = dv, t → ∞: μ_da → 1 − g σ_α/√(σ_a² + g² σ_α²), though da is not observable."""
    A = "[[0, -9.8, 0, 1], [1/6378137, 0, 1, 0], [0, 0, 0, 0], [0, 0, 0, 0]]"
    noise = "{R: 1e-4, step: 10, P0_std: [1, 1e-3, 1e-4, 1e-2]}"
    text = f"states: [dv, alpha, domega, da]\nA: {A}\nH: [[1, 0, 0, 0]]\nnoise: {noise}\n"
    found = measure(text, stop="40000", select=("stochastic",))
    g, alpha, a = 9.8, 1e-3, 1e-2
    assert found.state("stochastic")[3] == pytest.approx(1 - g * alpha / np.hypot(a, g * alpha), abs=1e-4)


def random_noisy(seed, *, driven=False):
    source = np.random.default_rng(seed)
    A = np.round(source.normal(size=(3, 3)) / 2, 2)
    H = np.round(source.normal(size=(2, 3)), 2)
    Q = ", Q: [0.01, 0.02, 0.03]" if driven else ""
    noise = f"{{R: [0.5, 2], step: 0.25, P0_std: [1, 2, 3]{Q}}}"
    text = f"states: [a, b, c]\nA: {A.tolist()}\nH: {H.tolist()}\nnoise: {noise}\n"
    return text, A, H


@pytest.mark.parametrize("seed", range(4))
def test_information_of_prior_and_samples_adds_up(measure, seed):
    """P⁻¹ = Φ⁻ᵀ P₀⁻¹ Φ⁻¹ + J; the bound is J⁻¹, the filter P, whichever way they are found."""
    text, A, H = random_noisy(seed)
    found = measure(text, stop="3", select=("standard-deviation", "cramer-rao", "covariance-reduction"))
    times = np.arange(0, 3.01, 0.25)
    rows = [H @ expm(A * (t - 3)) for t in times]
    J = sum(h.T @ np.diag([2, 0.5]) @ h for h in rows)
    inverse = expm(-3 * A)
    P = np.linalg.inv(inverse.T @ np.diag([1, 1 / 4, 1 / 9]) @ inverse + J)
    sigma = np.sqrt(np.diag(P))
    assert found.state("cramer-rao") == pytest.approx(np.sqrt(np.diag(np.linalg.inv(J))), rel=1e-8)
    assert found.state("standard-deviation") == pytest.approx(sigma, rel=1e-8)
    assert found.state("covariance-reduction") == pytest.approx(sigma / [1, 2, 3], rel=1e-8)


@pytest.mark.parametrize("seed", range(4))
def test_the_bound_is_what_the_filter_tends_to_as_the_prior_widens(measure, seed):
    text, _, _ = random_noisy(seed, driven=True)
    wide = measure(text.replace("[1, 2, 3]", "[1e5, 2e5, 3e5]"), stop="3")
    assert wide.state("standard-deviation") == pytest.approx(wide.state("cramer-rao"), rel=1e-6)
    narrow = measure(text, stop="3")
    assert (np.array(narrow.state("standard-deviation")) < np.array(narrow.state("cramer-rao"))).all()


def test_eigenvalues_of_the_normalised_covariance_add_up_to_the_number_of_states(measure):
    text, _, _ = random_noisy(1)
    found = measure(text, stop="3", select=("normalised-covariance",))
    assert sum(found.sizes("normalised-covariance")) == pytest.approx(3)
    alone = measure(
        "states: [a, b]\nA: [[0, 0], [0, 0]]\nH: [[1, 0]]\nnoise: {R: 1, step: 1, P0_std: [2, 5]}\n", stop="3"
    )
    learned, kept = alone.system("normalised-covariance")
    assert learned.components == {"a": 1.0}
    assert kept.components == {"b": 1.0}
    assert learned.value / kept.value == pytest.approx(1 / (1 + 4 * 4))


def test_units_of_the_states_do_not_change_what_the_noise_says(measure):
    plain, _, _ = random_noisy(2)
    keys = ("stochastic", "standard-deviation", "cramer-rao", "covariance-reduction")
    given, scaled = measure(plain, stop="3"), measure(plain, stop="3", scaling="prior")
    for key in keys:
        assert scaled.state(key) == pytest.approx(given.state(key), rel=1e-12)


def test_too_few_samples_give_no_bound(measure):
    """One sample of the position tells nothing of the velocity, though it is observable."""
    text = "states: [x, v]\nA: [[0, 1], [0, 0]]\nH: [[1, 0]]\nnoise: {R: 1, step: 5, P0_std: [1, 1]}\n"
    assert (
        "do not tell all observable combinations apart"
        in measure(text, stop="4").taken.found["cramer-rao"].reason
    )
    assert measure(text, stop="5").state("cramer-rao") == pytest.approx([1, np.sqrt(2) / 5])


@pytest.mark.parametrize("order", ["p, b, k", "b, k, p"])
def test_a_bound_is_zero_where_a_state_decays_under_the_samples(measure, order):
    """A day of a Gauss-Markov process in a velocity; k decays as fast and hides behind what b did to p."""
    text = (
        f"states: [{order}]\ndynamics: {{p: b + k, b: -b/100, k: -k/100}}\nmeasurements: {{z: p}}\n"
        "noise: {R: 1, step: 10, P0_std: {p: 10, b: 1, k: 2}}\n"
    )
    found = measure(text, stop="86400", select=("cramer-rao", "stochastic", "standard-deviation"))
    bound, sigma = (
        [found.state(key)[order.split(", ").index(s)] for s in "pbk"]
        for key in ("cramer-rao", "standard-deviation")
    )
    t = np.arange(-86400, 1, 10.0)
    g = np.exp(-(t + 86400) / 100)
    assert bound[0] == pytest.approx((len(t) - g.sum() ** 2 / (g @ g)) ** -0.5, rel=1e-8)
    assert bound[1:] == [np.inf, np.inf]
    assert found.combination("cramer-rao") == [0.0]
    assert sigma[0] == pytest.approx(bound[0], rel=1e-4)


def test_what_is_learned_of_an_instability_is_all_where_the_open_loop_is_beyond_all_numbers(measure):
    text = "states: [x]\nA: [[1]]\nH: [[1]]\nnoise: {R: 1, step: 0.5, P0_std: [1]}\n"
    found = measure(text, stop="1000", select=("cramer-rao", "stochastic", "standard-deviation"))
    assert found.state("stochastic") == [1.0]
    assert found.state("standard-deviation") == pytest.approx([np.sqrt(1 - np.exp(-1))], rel=1e-9)
    assert found.state("cramer-rao") == pytest.approx(found.state("standard-deviation"), rel=1e-9)


def test_a_direction_known_without_end_beside_one_that_is_driven_is_not_resolved(measure):
    """Noise common to two decaying states: of their difference e^2t, of their sum never more than of w."""
    text = (
        "states: [a, b]\ndisturbances: [w]\nA: [[-1, 0], [0, -1]]\nG: [[1], [1]]\nH: [[1, 0], [0, 1]]\n"
        "noise: {R: [1, 4], step: 0.5, Q: [0.3], P0_std: [1e5, 1e5]}\n"
    )
    short = measure(text, stop="10", select=("cramer-rao", "standard-deviation"))
    assert short.state("cramer-rao") == pytest.approx(short.state("standard-deviation"), rel=1e-6)
    for stop in ("100", "1000"):
        found = measure(text, stop=stop, select=("cramer-rao",)).taken.found["cramer-rao"]
        assert "do not tell all observable combinations apart" in found.reason


def test_what_is_missing_is_said(measure):
    text = "states: [x, v]\nA: [[0, 1], [0, 0]]\nH: [[1, 0]]\n"
    assert "no `noise`" in measure(text).taken.found["stochastic"].reason
    with_r = measure(text + "noise: {R: 1, step: 1, P0_std: {x: 1}}\n", stop="9")
    reason = with_r.taken.found["standard-deviation"].reason
    assert "v" in reason
    assert "P0" in reason
    assert with_r.state("cramer-rao")[1] < np.inf
