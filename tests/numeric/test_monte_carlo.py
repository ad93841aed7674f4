"""Runs with random errors: they spread as the covariance says, and the same seed gives the same runs."""

import numpy as np
import pytest
from scipy.stats import chi2

from obscli.numeric.errors import NotComputableError
from obscli.numeric.kalman import covariance_history
from obscli.numeric.linear_forms import forms_of
from obscli.numeric.mismatched import mismatch_history
from obscli.numeric.monte_carlo import monte_carlo
from obscli.numeric.recorded_errors import recorded_errors
from obscli.numeric.schedule import schedule_of


TURNING = """\
states: [x, y, b]
dynamics: {x: cos(t)*y + b, y: -x/3 - y/5, b: 0}
measurements: {p: x, q: y + sin(t/2)*b}
noise: {R: [[0.04, 0.05], [0.05, 0.25]], step: 0.25, P0_std: [1, 2, 0.5], Q: {x: 0.1, b: 0.01}}
quantities: {turned: cos(t)*x + sin(t)*y}
"""
WITHOUT_B = """\
states: [x, y]
dynamics: {x: cos(t)*y, y: -x/3 - y/5}
measurements: {p: x, q: y}
noise: {R: [[0.04, 0.05], [0.05, 0.25]], step: 0.5, P0_std: [1, 2], Q: {x: 0.1}}
"""
RUNS = 2000


def drawn(given, stop=10, runs=RUNS, seed=7, recorded=200, **options):
    run = recorded_errors(given, schedule_of(given, 0, stop), forms_of(given), recorded)
    return monte_carlo(run, runs, seed, **options)


def errors_of(truth, design):
    true, own = (schedule_of(one, 0, 10) for one in (truth, design))
    return recorded_errors(truth, true, forms_of(design), 200, filter_=design, filter_schedule=own)


def test_errors_spread_as_the_filter_claims(system):
    """Of N runs the mean is within 5 σ/√N of zero, the rms within 5 σ/√(2N) of σ: 1 in 10⁶ per number."""
    given = system(TURNING)
    found = drawn(given)
    alone = covariance_history(given, schedule_of(given, 0, 10), forms_of(given), recorded=200)
    assert found.names == ("x", "y", "b", "turned")
    assert found.t == pytest.approx(alone.t)
    assert found.claimed == pytest.approx(alone.deviations, rel=1e-9)
    assert (np.abs(found.mean) < 5 * found.claimed / np.sqrt(RUNS)).all()
    assert (np.abs(found.rms / found.claimed - 1) < 5 / np.sqrt(2 * RUNS)).all()


def test_nees_and_nis_are_within_their_bands(system):
    """With one long history of few runs: values at neighbouring instants of the NIS are independent."""
    found = drawn(system(TURNING), stop=100, runs=20, recorded=500)
    assert len(found.nis.t) == 401
    assert 0.91 < found.nis.inside < 0.985
    assert 0.8 < found.nees.inside <= 1
    assert found.nis.average.mean() == pytest.approx(1, abs=5 * np.sqrt(2 / (401 * 40)))
    assert found.nees.lower[0] == pytest.approx(chi2.ppf(0.025, 60) / 60)
    assert found.nis.upper[-1] == pytest.approx(chi2.ppf(0.975, 40) / 40)


def test_where_nothing_is_uncertain_nothing_is_normalised(system):
    """A state that has decayed below the smallest number is known: P = 0, and P⁻¹ does not exist."""
    decaying = "states: [x]\nA: [[-1]]\nH: [[1]]\nnoise: {R: 1, step: 100, P0_std: 1}\n"
    found = drawn(system(decaying), stop=2000, runs=200)
    assert found.claimed[-1] == 0
    assert 0 < len(found.nees.t) < len(found.t)
    assert found.nees.t[-1] < 800
    assert np.isfinite(found.nees.average).all()
    assert len(found.nis.t) == 21


def test_a_seed_determines_the_runs_whatever_is_recorded(system):
    given = system(TURNING)
    one, again, few, other = drawn(given), drawn(given), drawn(given, recorded=5), drawn(given, seed=8)
    assert (one.rms == again.rms).all()
    assert (one.nees.average == again.nees.average).all()
    assert len(few.t) == 5
    assert (few.rms == one.rms[np.isin(one.t, few.t)]).all()
    assert not np.isclose(other.rms, one.rms).any(axis=1).all()


def test_runs_of_a_mismatched_filter_spread_as_the_true_covariance(system):
    truth, design = system(TURNING), system(WITHOUT_B)
    run = errors_of(truth, design)
    found, expected = monte_carlo(run, RUNS, 3), mismatch_history(run)
    assert found.t == pytest.approx(expected.t)
    assert found.claimed == pytest.approx(expected.claimed, rel=1e-9)
    assert (np.abs(found.rms / expected.true - 1) < 5 / np.sqrt(2 * RUNS)).all()
    assert expected.true[-1] / expected.claimed[-1] == pytest.approx(
        found.rms[-1] / found.claimed[-1], rel=0.1
    )
    assert found.nees.average[-1] > found.nees.upper[-1]
    assert found.nees.inside < 0.2


def test_a_filter_that_trusts_too_little_is_below_the_band(system):
    truth = system(TURNING)
    design = system(TURNING.replace("[[0.04, 0.05], [0.05, 0.25]]", "[[0.4, 0.5], [0.5, 2.5]]"))
    found = monte_carlo(errors_of(truth, design), 500, 3)
    assert (found.nis.average < found.nis.lower).mean() > 0.9


def test_errors_of_an_instability_are_drawn_where_the_state_is_beyond_all_numbers(system):
    given = system("states: [x]\nA: [[1]]\nH: [[1]]\nnoise: {R: 1, step: 0.5, P0_std: 1}\n")
    found = drawn(given, stop=1000, runs=500, recorded=50)
    assert found.claimed[-1, 0] == pytest.approx(np.sqrt(1 - np.exp(-1)), rel=1e-10)
    assert (np.abs(found.rms / found.claimed - 1) < 5 / np.sqrt(2 * 500)).all()


def test_a_covariance_that_is_singular_counts_its_range_only(system):
    """h follows c until they differ by less than rounding: from two degrees of freedom to one."""
    given = system(
        "states: [h, c]\ndynamics: {h: 3*(c - h), c: 0}\nmeasurements: {y: c}\n"
        "noise: {R: 1, step: 1, P0_std: [1, 1]}\n"
    )
    found = drawn(given, stop=20, runs=100)
    assert found.nees.upper[[0, -1]] == pytest.approx(
        [chi2.ppf(0.975, 200) / 200, chi2.ppf(0.975, 100) / 100]
    )
    assert 0.5 < found.nees.average[-1] < 1.5


def test_one_output_at_a_time_counts_one_degree(system):
    found = drawn(
        system("states: [x]\nA: [[0]]\nmeasurements: {y: x}\nnoise: {R: 1, step: 1, P0_std: 1}\n"),
        runs=10,
    )
    assert found.nis.lower == pytest.approx(chi2.ppf(0.025, 10) / 10)


def test_an_interrupt_keeps_what_is_done(system):
    given = system(TURNING)
    seen = []

    def interrupted(text):
        seen.append(text)
        if len(seen) == 10:
            raise KeyboardInterrupt

    found, whole = drawn(given, runs=50, progress=interrupted), drawn(given, runs=50)
    k = len(found.t)
    assert (found.complete, whole.complete) == (False, True)
    assert 0 < k < len(whole.t)
    assert (found.rms == whole.rms[:k]).all()
    assert len(found.nees.t) == k


def test_no_run_is_refused(system):
    with pytest.raises(NotComputableError, match="at least one"):
        drawn(system(TURNING), runs=0)
