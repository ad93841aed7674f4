"""The error beside a panel's Φ covers the true one: |ΔΦ| ≤ estimate + a few roundings of max(1, Φ)."""

import mpmath
import numpy as np
import pytest

from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.rates import rates_of
from obscli.numeric.settings import Effort
from obscli.numeric.transition import longest_step, panels


EPS = np.finfo(float).eps
ROUNDINGS = 4


def integral(f, a, b):
    return mpmath.quad(f, mpmath.linspace(a, b, 4))  # over a short panel


SCALAR = {
    "cos(t)": lambda a, b: mpmath.exp(mpmath.sin(a) - mpmath.sin(b)),
    "-1/(1 + t)": lambda a, b: (1 + b) / (1 + a),
    "3": lambda a, b: mpmath.exp(3 * (a - b)),
    "-3": lambda a, b: mpmath.exp(3 * (b - a)),
    "4*t": lambda a, b: mpmath.exp(2 * (a * a - b * b)),
    "exp(sin(20*t))": lambda a, b: mpmath.exp(integral(lambda t: mpmath.exp(mpmath.sin(20 * t)), b, a)),
    "1/(1/100 + t^2)": lambda a, b: mpmath.exp(10 * (mpmath.atan(10 * a) - mpmath.atan(10 * b))),
}


def shares(system, A, exact, longest, rtol):
    """True errors and estimates of all panels on [0, 3]."""
    found = NumericSystem(system(f"states: [x]\nA: [['{A}']]\nH: [[1]]\n"), 0.0, 3.0)
    edges = np.linspace(0, 3, int(np.ceil(3 / longest)) + 1)
    true, estimate, size, a = [], [], [], 0.0
    with mpmath.workdps(30):
        for piece in panels(found, edges, Effort(rtol, 20_000)):
            for b, phi, squared in zip(piece.ends, piece.transition, piece.transition_error, strict=True):
                expected = exact(mpmath.mpf(a), mpmath.mpf(b))
                true.append(float(abs(mpmath.mpf(phi[0, 0]) - expected)))
                estimate.append(float(np.sqrt(squared[0, 0])))
                size.append(max(1.0, float(expected)))
                a = b
    return np.array(true), np.array(estimate), np.array(size)


@pytest.mark.parametrize("rtol", [1e-6, 1e-10, 1e-14])
@pytest.mark.parametrize("stretched", [1, 2])
@pytest.mark.parametrize("A", SCALAR)
def test_the_estimate_covers_the_true_error(system, A, stretched, rtol):
    given = NumericSystem(system(f"states: [x]\nA: [['{A}']]\nH: [[1]]\n"), 0.0, 3.0)
    longest = min(longest_step(rates_of(given, np.linspace(0, 3, 18)[1:-1])), 3.0) * stretched
    true, estimate, size = shares(system, A, SCALAR[A], longest, rtol)
    assert (true <= estimate + ROUNDINGS * EPS * size).all()
    # and the tolerance is met: the error of a panel is its share of rtol, of what A Φ is integrated from
    assert (true <= (rtol + ROUNDINGS * EPS) * size).all()


@pytest.mark.parametrize("rtol", [1e-6, 1e-10])
@pytest.mark.parametrize("A", ["cos(t)", "-1/(1 + t)", "-3", "exp(sin(20*t))"])
def test_the_estimate_is_within_the_tolerance(system, A, rtol):
    """The tail of A Φ is held to rtol, and integrated over panels shorter than 2/|A|."""
    _, estimate, size = shares(system, A, SCALAR[A], 0.5, rtol)
    assert (estimate <= (rtol + ROUNDINGS * EPS) * size).all()


def test_the_estimate_sees_an_error_that_is_there(system):
    """Panels too long for the tolerance asked: errors of 1e-7 and more are not taken for rounding."""
    true, estimate, _ = shares(system, "exp(sin(20*t))", SCALAR["exp(sin(20*t))"], 0.375, 1e-2)
    assert true.max() > 1e-12
    assert (true <= estimate + 1e-15).all()


def test_the_error_of_coefficients_is_passed_on(system):
    """big + x − big has few digits left, and so has Φ."""
    text = "parameters: {big: {BIG}, x: 0.7}\nstates: [a]\nA: [['(big + x) - big']]\nH: [[1]]\n"
    found = []
    for big in ("1", "1e6", "1e9"):
        given = NumericSystem(system(text.replace("{BIG}", big)), 0.0, 1.0)
        (piece,) = panels(given, np.array([0.0, 1.0]), Effort(1e-14, 100))
        off = abs(piece.transition[0, 0, 0] - np.exp(-0.7))
        found.append(np.sqrt(piece.transition_error[0, 0, 0]))
        assert off <= 40 * found[-1] + ROUNDINGS * EPS
    assert found[1] > 1e5 * EPS / 20
    assert found[2] > 1e8 * EPS / 20
