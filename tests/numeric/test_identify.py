"""A guessed form is right or says that it is none: it fits where it was not fitted, and no other fits as well."""

import numpy as np
import pytest

from obscli.checks.guesses import check_guesses
from obscli.model.expression import symbols
from obscli.model.notation import to_text
from obscli.numeric.echelon import echelon_curves
from obscli.numeric.identify import Identifier, identified
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import Program


INSTANTS = np.linspace(0.3, 40, 90)
TEXT = """
parameters: {w: 0.37, g: 9.81, k: 1.7, twin: 1.7, phi: 0.47}
states: [a, b]
A: {a: {b: "g*cos(w*t)*cos(phi)"}}
H: {y: {a: k, b: "twin + exp(-t/20)"}}
"""


@pytest.fixture(scope="module")
def known(system):
    """A system whose dictionary has w, g, k, twin, phi; waves of w t; exp(−t/20)."""
    return NumericSystem(system(TEXT), 0.0, 40.0)


@pytest.fixture(scope="module")
def guess(known):
    identifier = Identifier(known, INSTANTS)

    def of(curve, error=1e-12, noise=0.0):
        values = np.broadcast_to(curve, INSTANTS.shape) * (
            1 + noise * np.random.default_rng(0).normal(size=INSTANTS.shape)
        )
        return identifier.guess(values, np.full(INSTANTS.shape, error * np.abs(values).max()))

    return of


T, W, G, K, PHI = INSTANTS, 0.37, 9.81, 1.7, 0.47


@pytest.mark.parametrize(
    ("curve", "text"),
    [
        (G, "g"),
        (-W / G, "-w/g"),
        (2 * W, "2*w"),
        (G * np.sin(W * T), "g*sin(w*t)"),
        (-np.cos(W * T) / 2, "-1/2*cos(w*t)"),
        (W * T, "w*t"),
        (W * np.cos(PHI) * np.cos(W * T), "w*cos(phi)*cos(w*t)"),
        (1 + np.cos(2 * W * T), "1 + cos(2*w*t)"),
        (G * np.exp(-T / 20) + W, "w + g*exp(-1/20*t)"),
        (G + W, "g + w"),
        (3 * np.sin(W * T) - W * T * np.cos(W * T), "3*sin(w*t) - w*t*cos(w*t)"),
    ],
)  # fmt: skip
def test_forms_of_the_dictionary_are_found(known, guess, curve, text):
    found = guess(curve)
    assert found.expression is not None, found.reason
    assert not found.in_digits, to_text(found.expression)
    value = Program([found.expression]).run(known.values(INSTANTS, {}))[0]
    np.testing.assert_allclose(value, np.broadcast_to(curve, T.shape), rtol=1e-11, atol=1e-12)
    names = symbols(found.expression) - {"t"}
    assert names == {name for name in ("w", "g", "phi") if name in text}, to_text(found.expression)
    assert max(found.residual, found.held_back) < 1e-11


@pytest.mark.parametrize("noise", [1e-3, 1e-6, 1e-9])
@pytest.mark.parametrize("curve", [G * np.sin(W * T), np.full(T.shape, G), 1 + np.cos(2 * W * T)])
def test_noise_above_the_stated_error_is_no_form(guess, curve, noise):
    found = guess(curve, error=min(noise / 10, 1e-5), noise=noise)
    assert found.expression is None
    assert found.reason == "no form of the dictionary fits"


def test_noise_within_the_stated_error_does_not_hide_a_form(guess):
    found = guess(G * np.sin(W * T), error=5e-9, noise=1e-9)
    assert to_text(found.expression) == "g*sin(w*t)"


@pytest.mark.parametrize(
    "curve",
    [
        np.sin(0.0713 * T + 0.3),
        np.sin(W * T * 1.001),
        np.exp(-T / 21),
        np.tanh(T / 7),
        1 / (1 + T),
        np.abs(T - 20),
        np.random.default_rng(1).normal(size=T.shape),
    ],
)
def test_what_is_not_in_the_dictionary_is_not_identified(guess, curve):
    found = guess(curve)
    assert found.expression is None
    assert found.reason == "no form of the dictionary fits"


def test_a_curve_known_too_coarsely_is_not_identified(known, guess):
    assert guess(G * np.sin(W * T), error=1e-3).reason == "known too coarsely, or at too few instants"
    few = Identifier(known, T[:8])
    found = few.guess(G * np.sin(W * T[:8]), np.full(8, 1e-12))
    assert found.expression is None
    assert found.reason == "known too coarsely, or at too few instants"


def test_instants_known_coarsely_are_left_out(known):
    """Where the error is large anything may stand."""
    curve, error = G * np.sin(W * T), np.full(T.shape, 1e-12)
    curve[:20] += 5
    error[:20] = 10
    assert to_text(Identifier(known, T).guess(curve, error).expression) == "g*sin(w*t)"


def test_parameters_with_equal_values_are_not_told_apart(guess):
    found = guess(K * np.sin(W * T))
    assert found.in_digits
    assert symbols(found.expression) == {"w", "t"}
    assert to_text(found.expression) == "17*sin(w*t)/10"


def test_an_amplitude_that_is_no_monomial_stays_a_number(guess):
    found = guess(0.1234567 * np.cos(W * T))
    assert found.in_digits
    assert to_text(found.expression) == "1234567*cos(w*t)/10000000"


@pytest.mark.parametrize("error", [1e-12, 1e-8, 1e-6])
def test_a_number_has_no_more_digits_than_are_known(known, guess, error):
    amplitude = 0.12345678901234567
    found = guess(amplitude * np.cos(W * T), error=error)
    value = Program([found.expression]).run(known.values(np.array([0.0]), {}))[0][0]
    assert abs(value - amplitude) < 10 * max(error, 1e-10) * amplitude


def test_random_amplitudes_are_not_taken_for_monomials(guess):
    """A name is given where chance would give it once in a thousand look-ups, among 14 000 monomials."""
    found = [guess(a * np.cos(W * T), error=9e-5) for a in np.random.default_rng(5).uniform(0.01, 20, 150)]
    assert sum(one.expression is not None for one in found) > 100
    assert sum(one.expression is not None and not one.in_digits for one in found) <= 2


def test_ins_stage_2_is_identified_and_proved(numeric, exact, bundled):
    given = bundled("ins_calibration/horizontal.yaml", "stage_2")
    found, proved = numeric(given), exact(given)
    finding = identified(echelon_curves(found), found.system)
    assert len(finding.curves) == 10
    names = given.state_names
    rows, _ = found.system.covectors([c.coefficients for c in proved.combinations], found.horizon.instants)
    pivots = [min(names.index(state) for state in c.coefficients) for c in proved.combinations]
    for one in finding.curves:
        assert one.guess.expression is not None, (one.pivot, one.free, one.guess.reason)
        assert not one.guess.in_digits
        row = rows[:, pivots.index(names.index(one.pivot))]
        expected = row[:, names.index(one.free)] / row[:, names.index(one.pivot)]
        np.testing.assert_allclose(one.fitted, expected, rtol=1e-12, atol=1e-13 * np.abs(expected).max())
    assert {one.standing for one in check_guesses(finding, proved).curves} == {"proved"}


def test_no_guess_of_a_bundled_stage_is_wrong(numeric, exact, bundled):
    """Algebra refutes none; where a sum of two rates is meant (0.10003…), digits stay."""
    for path, stage in (
        ("ins_calibration/horizontal.yaml", "stage_1"), ("ins_calibration/horizontal.yaml", "stage_3"),
        ("ins_calibration/vertical.yaml", "stage_1"), ("ins_calibration/pole.yaml", "stage_2"),
        ("textbook/levelling.yaml", None), ("textbook/mixed_coefficients.yaml", None),
    ):  # fmt: skip
        given = bundled(path, stage)
        found = numeric(given)
        curves = check_guesses(identified(echelon_curves(found), found.system), exact(given)).curves
        assert curves
        for one in curves:
            assert one.standing == ("guess" if one.guess.in_digits else "proved"), (one.pivot, one.free)


def test_a_curve_that_is_refused_has_no_fit(numeric):
    """y = h a + t b with h = 1 + t + t³ shows a + t/h b, and 1/h stands nowhere in A and H."""
    text = """
states: [a, b]
A: {a: {b: "(2*t^3 - 1)*(1 + t + t^3)^(-2)"}}
H: {y: {a: "1 + t + t^3", b: t}}
interval: {stop: 4, samples: 60}
"""
    found = numeric(text)
    (one,) = identified(echelon_curves(found), found.system).curves
    t = np.array(one.instants)
    np.testing.assert_allclose(one.values, t / (1 + t + t**3), rtol=1e-11)
    assert (one.standing, one.fitted, one.guess.expression) == ("not identified", None, None)
