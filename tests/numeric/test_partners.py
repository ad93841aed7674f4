"""How well a combination is known, its partners and its floor: against closed forms and the laws of P."""

import numpy as np
import pytest

from obscli.model.covector import parse_covector
from obscli.model.reader import read_text
from obscli.numeric.partners import knowledge


#: Two constants of which the sum is measured at N = 11 instants.
SUM = """\
states: [a, b]
A: zeros(2, 2)
H: [[1, 1]]
noise: {R: 0.5, step: 1, P0_std: {a: 2, b: 3}}
"""


def known(text, target, stop=10):
    system = read_text(text, "test.yaml").systems[0]
    return knowledge(system, parse_covector(system, target, "test").coefficients, 0, stop)


def of_the_sum(R=0.5, a=2, b=3):
    """P = P0 − P0 c cᵀ P0 / (c P0 cᵀ + R/N)."""
    P0, c = np.diag([a * a, b * b]), np.ones(2)
    return P0 - np.outer(P0 @ c, P0 @ c) / (c @ P0 @ c + R / 11)


@pytest.mark.parametrize(
    ("target", "c"), [("a", (1, 0)), ("b", (0, 1)), ("a + b", (1, 1)), ("3*a - b", (3, -1))]
)
def test_two_constants_of_which_the_sum_is_measured_have_their_closed_form(target, c):
    found, P, c = known(SUM, target), of_the_sum(), np.array(c)
    sigma = np.sqrt(c @ P @ c)
    rho = (P @ c) / (sigma * np.sqrt(np.diag(P)))
    assert found.before == pytest.approx(np.sqrt(c**2 @ [4, 9]))
    assert found.after == pytest.approx(sigma)
    expected = {name: r for name, r in zip("ab", rho, strict=True) if abs(r) > 0.5 and name != target}
    assert dict(found.partners) == pytest.approx(expected)
    assert found.without["R"] == pytest.approx(np.sqrt(c @ of_the_sum(R=0.005) @ c) / sigma)
    assert found.without["P0"] == pytest.approx(np.sqrt(c @ of_the_sum(a=0.2, b=0.3) @ c) / sigma)


def test_each_of_two_that_are_told_apart_by_nothing_is_the_other_s_partner():
    [(name, rho)] = known(SUM, "a").partners
    assert name == "b"
    assert rho < -0.99


def test_partners_are_at_most_three_the_closest_first():
    names = [f"x{k}" for k in range(1, 7)]
    rows = [
        "[1, 1, 0, 0, 0, 0]",
        "[1, 0, 1, 0, 0, 0]",
        "[1, 0, 0, 1, 0, 0]",
        "[1, 0, 0, 0, 1, 0]",
        "[0, 0, 0, 0, 0, 1]",
    ]
    text = f"states: [{', '.join(names)}]\nA: zeros(6, 6)\nH: [{', '.join(rows)}]\n"
    found = known(text + "noise: {R: [1e-3, 1e-2, 1e-1, 1, 1], step: 1, P0_std: 1}\n", "x1")
    assert [name for name, _ in found.partners] == ["x2", "x3", "x4"]
    sizes = [abs(rho) for _, rho in found.partners]
    assert sizes == sorted(sizes, reverse=True)


@pytest.mark.parametrize(
    ("dynamics", "measured", "noise", "floor", "left"),
    [
        ("x: 0*x", "z", "R: 1, P0_std: 3", "P0", 0.1),  # hidden: nothing but the prior
        ("x: 0*x", "x", "R: 1, P0_std: 1e3", "R", 0.1),  # measured, and nothing known before
        ("x: -x", "z", "R: 1, Q: {x: 2}, P0_std: 1", "Q", 0.0),  # hidden and driven: the stationary variance
    ],
)
def test_the_floor_is_set_by_the_prior_the_outputs_or_the_driving_noise(
    dynamics, measured, noise, floor, left
):
    text = (
        f"states: [x, z]\ndynamics: {{{dynamics}, z: -z}}\nmeasurements: {{y: {measured}}}\n"
        f"noise: {{{noise}, step: 0.1}}\n"
    )
    found = known(text, "x", stop=20)
    assert found.floor == floor
    assert found.without[floor] == pytest.approx(left, abs=1e-3)


@pytest.mark.parametrize("target", ["p", "v", "b", "v - 2*b", "p + v"])
@pytest.mark.parametrize("Q", ["0.01", "1", "100"])
def test_one_of_the_three_lowers_the_variance_by_nearly_a_third(target, Q):
    """P is concave and homogeneous in (Q, R, P0), so their shares add up to at most what each one lowers."""
    text = (
        "states: [p, v, b]\ndynamics: {p: v, v: b}\nmeasurements: {y: p}\n"
        f"noise: {{R: 1, Q: {{v: {Q}}}, step: 0.5, P0_std: {{p: 5, v: 2, b: 0.3}}}}\n"
    )
    found = known(text, target, stop=5)
    lowered = {name: 1 - left**2 for name, left in found.without.items()}
    assert sum(lowered.values()) >= 0.99
    assert lowered[found.floor] == max(lowered.values()) >= 0.33


def test_priors_that_the_file_does_not_give_are_named():
    text = (
        "states: {x: {scale: 5}, z: {scale: 7}}\nA: zeros(2, 2)\nH: [[0, 1]]\nnoise: {R: 1, P0_std: {z: 2}}\n"
    )
    found = known(text, "x", stop=1)
    assert (found.assumed, found.before, found.after) == (("x",), pytest.approx(5), pytest.approx(5))
