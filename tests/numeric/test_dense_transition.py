"""Φ(t, a) within panels: exponentials where nothing varies, and solved once for panels that are alike."""

from itertools import pairwise

import mpmath
import numpy as np
import pytest
from scipy.special import factorial

from obscli.numeric.dense_transition import dense_transitions
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.sampled_system import SampledSystem, timeline_of
from obscli.numeric.schedule import schedule_of


OSCILLATORS = np.array([[0, 3, 0, 1], [-3, -0.1, 2, 0], [0, 0, 0, 5], [0, 0, -5, 0]])
EDGES = np.array([0.0, 0.4, 0.77, 1.1, 1.13, 1.15, 1.5])


def constant(A, more=""):
    n = len(A)
    return f"states: {{x: {{shape: {n}}}}}\nA: {A.tolist()}\nH: [{np.eye(n)[0].tolist()}]\n{more}"


def whole(dense, rows, n):
    """Return Φ (k, n, n), given the rows of the states that move."""
    found = np.tile(np.eye(n), (len(rows), 1, 1))
    found[:, dense.moving] = rows
    return found


def exponential(A, T):
    with mpmath.workdps(30):
        return np.array(mpmath.expm(mpmath.matrix(A.tolist()) * mpmath.mpf(T)).tolist(), dtype=float)


def test_where_nothing_varies_panels_of_any_length_are_exponentials(system):
    given = NumericSystem(system(constant(OSCILLATORS)), 0.0, 1.5)
    found = list(dense_transitions(given, EDGES))
    assert [(one.start, one.stop) for one in found] == list(pairwise(EDGES))
    for one in found:
        t = one.start + (one.stop - one.start) * np.array([0, 1 / 7, 0.6, 1])
        exact = np.array([exponential(OSCILLATORS, s - one.start) for s in t])
        np.testing.assert_allclose(whole(one, one.forward(t), 4), exact, atol=4e-15)
        back = np.array([exponential(OSCILLATORS, one.start - s) for s in t])
        np.testing.assert_allclose(whole(one, one.backward(t), 4), back, atol=6e-15)


def test_short_panels_of_a_chain_keep_the_digits_of_their_small_entries(system):
    """h^k/k! of a panel of 0.02 is not taken from the polynomials of one of 0.4."""
    n = 8
    given = NumericSystem(system(constant(np.eye(n, k=1))), 0.0, 1.5)
    power = np.maximum(np.arange(n) - np.arange(n)[:, None], 0)
    for one in dense_transitions(given, EDGES):
        h = one.stop - one.start
        exact = np.triu(h**power / factorial(power))
        found = whole(one, one.forward(np.array([one.stop])), n)[0]
        np.testing.assert_allclose(found, exact, rtol=1e-10)


@pytest.mark.parametrize("n", [3, 40])
def test_the_coefficients_of_panels_alike_are_looked_at_once(system, monkeypatch, n):
    """The panels forced on an interval are 64 and more, but all of them are one where nothing varies."""
    given = system(constant(1e-5 * np.eye(n, k=1), "noise: {R: 1, step: 1, P0_std: {x: 1}}\n"))
    schedule = schedule_of(given, 0, 20)
    sampled = SampledSystem(given, schedule)
    seen = []
    matrices = NumericSystem.matrices
    monkeypatch.setattr(NumericSystem, "matrices", lambda s, t: seen.append(len(t)) or matrices(s, t))
    timeline = timeline_of([sampled, sampled], schedule)
    assert len(list(sampled.stretches(timeline))) == len(timeline.edges) - 1 >= 64
    assert sum(seen) <= 8 * 16
