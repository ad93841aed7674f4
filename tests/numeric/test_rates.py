"""Rates are those of the system, whatever the units of its states."""

import numpy as np
import pytest

from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.rates import rates_of


T = np.linspace(0.1, 9.9, 50)


@pytest.fixture(scope="session")
def rates(system):
    return lambda text: rates_of(NumericSystem(system(text), 0.0, 10.0), T)


@pytest.mark.parametrize(
    ("A", "dynamics", "backward"),
    [
        ("[[0, 3], [-3, 0]]", 3, 0),
        ("[[-2, 1], [0, -5]]", 5, 5),
        ("[[2, 1], [0, -1]]", 2, 1),
        ("[[0, 0], [0, 0]]", 0, 0),
        ("[[0, 2], [2, 0]]", 2, 2),
    ],
)
def test_rates_of_the_dynamics(rates, A, dynamics, backward):
    found = rates(f"states: [a, b]\nA: {A}\nH: [[1, 0]]\n")
    assert found.dynamics == pytest.approx(dynamics, abs=1e-12)
    assert found.backward == pytest.approx(backward, abs=1e-12)
    assert found.coefficients == 0


@pytest.mark.parametrize(
    ("entry", "rate"),
    [
        ("cos(5*t)", 5),
        ("exp(-t/3)", 1 / 3),
        ("sin(t^2/10)", 2),
        ("cos(5*t)*sin(7*t)", 7),
        ("t^3", 0),
        ("2*sin(3)", 0),
    ],
)
def test_rates_of_the_coefficients(rates, entry, rate):
    for text in (f"A: [['{entry}']]\nH: [[1]]\n", f"A: [[0]]\nH: [['{entry}']]\n"):
        assert rates(f"states: [a]\n{text}").coefficients == pytest.approx(rate, rel=0.02)


def test_rates_of_a_sample_motion_are_those_of_its_tones(rates):
    found = rates("functions: [f]\nstates: [a]\nA: [[0]]\nH: [[f]]\n")
    assert 2 * np.pi * 3.28 / 10 <= found.coefficients <= 2 * np.pi * 4.92 / 10


@pytest.mark.parametrize("size", [1e-6, 1e3, 1e12])
def test_units_of_the_states_do_not_matter(rates, size):
    plain = rates("states: [a, b]\nA: [['-cos(2*t)', 3], [-4, -0.5]]\nH: [[1, 0]]\n")
    scaled = rates(f"states: [a, b]\nA: [['-cos(2*t)', {3 * size!r}], [{-4 / size!r}, -0.5]]\nH: [[1, 0]]\n")
    for name in ("coefficients", "dynamics", "backward"):
        assert getattr(scaled, name) == pytest.approx(getattr(plain, name), rel=1e-9)


def test_a_state_that_drives_only_adds_no_rate(rates):
    """x' = 10⁹ c with c constant is no fast system: A is nilpotent."""
    found = rates("states: [x, c]\nA: {x: {c: 10^9}}\nH: {y: {x: 1}}\n")
    assert found.fastest == 0
