"""Noise added to a record and taken out of it: what the calmest record within the noise is, by its definition."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from obscli.numeric.signal_noise import calmed, calmest, noisier
from obscli.numeric.signals import Samples, slopes_of


def motion(t, s):
    return float((np.diff(s) ** 2 / np.diff(t)).sum())


def record(seed, n=300, size=1.0):
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.05, 0.2, n))
    return t, size * np.sin(t / 3) + 0.1 * rng.standard_normal(n)


@pytest.mark.parametrize("seed", range(20))
def test_noise_alone_becomes_a_constant(seed):
    t, y = record(seed, size=0.0)
    assert np.ptp(calmest(t, 5 + y, 0.1)) == 0


def test_noise_of_the_size_given_is_taken_out_and_no_more():
    for seed in range(5):
        t, y = record(seed)
        s = calmest(t, y, 0.1)
        assert np.sqrt(((s - y) ** 2).mean()) == pytest.approx(0.1 * (1 + 3 / np.sqrt(600)), rel=1e-6)
        assert np.sqrt(((s - np.sin(t / 3)) ** 2).mean()) < 0.09


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.02, 0.8))
def test_no_other_record_within_the_noise_moves_less(seed, deviation):
    t, y = record(seed, 12)
    s = calmest(t, y, deviation)
    allowed = (deviation * (1 + 3 / np.sqrt(24))) ** 2 * 12 * (1 + 1e-9)
    assert ((s - y) ** 2).sum() <= allowed
    away = {"type": "ineq", "fun": lambda x: allowed - ((x - y) ** 2).sum()}
    found = minimize(lambda x: motion(t, x), s, constraints=[away], method="SLSQP", options={"ftol": 1e-12})
    assert motion(t, s) <= found.fun * (1 + 1e-4) + 1e-9


@given(st.floats(-3, 3), st.floats(0.1, 10))
def test_shifts_and_scales_go_through(shift, factor):
    t, y = record(7, 60)
    expected = factor * calmest(t, y, 0.1) + shift
    assert calmest(t, factor * y + shift, factor * 0.1) == pytest.approx(
        expected, abs=1e-6 * (factor + abs(shift))
    )


def test_only_named_functions_are_changed():
    t, y = record(1)
    values = np.column_stack([y, 2 * y])
    given_ = Samples("f.csv", ("a", "b"), "cubic", t, values, slopes_of(t, values))
    for how in (calmed({"b": 0.2}), noisier({"b": 0.2}, 0)):
        found = how(0, given_)
        assert (found.values[:, 0] == y).all()
        assert (found.slopes[:, 0] == given_.slopes[:, 0]).all()
        assert 0.5 < np.std(found.values[:, 1] - 2 * y) / 0.2 < 1.2
        assert np.allclose(found.slopes, slopes_of(t, found.values))
    assert (noisier({"b": 0.2}, 0)(1, given_).values != noisier({"b": 0.2}, 0)(0, given_).values).any()
