"""Noise of sampled outputs as a density, and who refuses outages."""

import numpy as np
import pytest

from obscli.exact import analysis as exact_side
from obscli.model.covector import parse_covector
from obscli.model.reader import read_text
from obscli.numeric.errors import NotComputableError
from obscli.numeric.noise import noise_model, steps_of
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.partners import knowledge
from obscli.numeric.riccati import cross_check, samples_of


def system(R="", outputs="{}", step="", H="eye(3)"):
    noise = f"noise: {{R: {R}, P0_std: 1{step}}}\n" if R else ""
    return read_text(
        f"parameters: {{f_s: 4, s: }}\nstates: [a, b, c]\nA: zeros(3, 3)\nH: {H}\noutputs: {outputs}\n{noise}",
        "test.yaml",
    ).systems[0]


def density(given):
    """Return R as a density, from its whitening."""
    L = np.linalg.inv(noise_model(NumericSystem(given, 0.0, 1.0)).whitening)
    return L @ L.T


def test_of_every_output_the_covariance_is_multiplied_by_its_own_time_between_samples():
    given = system("[2, 3, 5]", "{y1: {every: 1/f_s}, y3: {every: 10}}")
    np.testing.assert_allclose(density(given), np.diag([2 / 4, 3, 50]), rtol=1e-14)
    assert steps_of(given) == (0.25, None, 10.0)
    given = system("[2, 3, 5]", "{y1: {every: 1/f_s}, y3: {every: 10}}", ", step: 7")
    np.testing.assert_allclose(density(given), np.diag([2 / 4, 21, 50]), rtol=1e-14)


def test_the_same_time_of_all_outputs_is_the_step():
    R = "[[2, 1, 0], [1, 3, -1], [0, -1, 5]]"
    one, other = system(R, "{y: {every: 0.3}}"), system(R, step=", step: 0.3")
    np.testing.assert_array_equal(density(one), density(other))
    np.testing.assert_allclose(
        density(one), 0.3 * np.array([[2, 1, 0], [1, 3, -1], [0, -1, 5]]), rtol=1e-13, atol=1e-15
    )


@pytest.mark.parametrize(
    "outputs", ["{y1: {every: 1}, y2: {every: 2}}", "{y1: {every: 1}}", "{y2: {every: 1}}"]
)
def test_correlated_outputs_are_sampled_alike_or_refused(outputs):
    with pytest.raises(NotComputableError, match="correlates y1 and y2, which are not sampled alike"):
        density(system("[[2, 1, 0], [1, 3, 0], [0, 0, 5]]", outputs))
    apart = density(system("[[2, 0, 0], [0, 3, 0], [0, 0, 5]]", outputs))
    assert np.count_nonzero(apart) == 3


def test_one_is_free_where_two_others_are_correlated():
    given = system(
        "[[2, 0, 1], [0, 3, 0], [1, 0, 5]]", "{y1: {every: 1/2}, y2: {every: 7}, y3: {every: 0.5}}"
    )
    np.testing.assert_allclose(density(given), [[1, 0, 0.5], [0, 21, 0], [0.5, 0, 2.5]], rtol=1e-13)


@pytest.mark.parametrize(
    ("every", "message"),
    [("s", "`outputs: y2: every` depends on s"), ("exp(-3) - 1", "`outputs: y2: every` must be positive")],
)
def test_a_time_that_is_no_positive_number_is_refused_by_name(every, message):
    with pytest.raises(NotComputableError, match=message):
        density(system("1", f"{{y2: {{every: {every}}}}}"))


def test_outputs_are_taken_as_often_as_the_most_frequent_one():
    instants, step = samples_of(system("1", "{y1: {every: 0.5}, y2: {every: 0.1}}"), 2, 3)
    assert step == 0.1
    np.testing.assert_allclose(instants, 2 + 0.1 * np.arange(1, 11))
    assert samples_of(system("1", "{y1: {every: 0.5}}", ", step: 0.25"), 0, 3)[1] == 0.25
    assert samples_of(system("1"), 0, 4)[1] == 0.01


def test_a_constant_is_known_as_well_as_its_own_samples_say():
    """Of N samples of covariance R: 1/P = 1/P0 + N/R, whatever the other outputs are sampled at.

    N is that of the density: 4001 samples of the most frequent output stand for 400.1 s of each.
    """
    given = system("[2, 3, 5]", "{y1: {every: 1}, y2: {every: 0.1}, y3: {every: 4}}")
    found = {
        name: knowledge(given, parse_covector(given, name, "test").coefficients, 0, 400).after
        for name in "abc"
    }
    expected = {"a": 1 + 400.1 / 2, "b": 1 + 4001 / 3, "c": 1 + 400.1 / 4 / 5}
    assert found == pytest.approx({name: one**-0.5 for name, one in expected.items()})


OUTAGE = "{y1: {during: [[0, 1], [3, 4]]}, y3: {during: [[0, 1]]}}"


def test_who_measures_all_the_time_refuses_outages_by_name():
    given = system("1", OUTAGE)
    one = parse_covector(given, "a", "test").coefficients
    for asked in (lambda: cross_check(given, 0, 1), lambda: knowledge(given, one, 0, 1)):
        with pytest.raises(NotComputableError, match=r"outages of y1, y3 .*obscli simulate"):
            asked()
    assert noise_model(NumericSystem(given, 0.0, 1.0)).P0.shape == (3, 3)


def test_the_exact_side_says_that_it_takes_no_outage_into_account():
    told = exact_side.analyze(system(outputs=OUTAGE)).notes
    assert len(told) == 1
    assert told[0].startswith("Outages of y1, y3 are not taken into account here")
    assert exact_side.analyze(system(outputs="{y1: {every: 1}}")).notes == ()
