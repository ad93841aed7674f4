"""Instants: those wanted, else the file's, else evenly over 20/(fastest rate); always after the start, in order."""

import math

import numpy as np
import pytest

from obscli.numeric.errors import NotComputableError, UnfitRequestError
from obscli.numeric.horizon import default_samples, horizon_of


def text(A="0", interval="", extra=""):
    given = f"interval: {{{interval}}}\n" if interval else ""
    return f"{extra}states: [x]\nA: [['{A}']]\nH: [[1]]\n{given}"


@pytest.fixture(scope="session")
def horizon(system, wanted):
    def find(model, **asked):
        given = system(model)
        return horizon_of(given, wanted(given, **asked))

    return find


def test_the_files_interval(horizon):
    found = horizon(text(interval="start: 1, stop: 2*pi, samples: 5"))
    assert (found.start, found.origin, len(found.instants)) == (1, "given", 5)
    np.testing.assert_allclose(found.instants, 1 + (2 * math.pi - 1) * np.arange(1, 6) / 5, rtol=1e-15)
    assert found.stop == found.instants[-1]


@pytest.mark.parametrize(
    ("asked", "start", "stop", "count"),
    [
        ({}, 1, 9, 4),
        ({"start": 2}, 2, 9, 4),
        ({"stop": "10/2"}, 1, 5, 4),
        ({"samples": 7}, 1, 9, 7),
        ({"start": "-1", "stop": "a"}, -1, 3, 4),
        ({"start": 0, "stop": 1, "samples": 1}, 0, 1, 1),
    ],
)
def test_what_is_wanted_wins_over_the_file(horizon, asked, start, stop, count):
    model = text(interval="start: 1, stop: 9, samples: 4", extra="parameters: {a: 3}\n")
    found = horizon(model, **asked)
    assert (found.start, found.stop, len(found.instants)) == (start, pytest.approx(stop, rel=1e-15), count)
    np.testing.assert_allclose(np.diff([start, *found.instants]), (stop - start) / count, rtol=1e-12)
    assert found.origin == "given"


def test_instants_one_by_one_are_sorted_and_taken_once(horizon):
    found = horizon(text(interval="stop: 9"), times=("3", "pi", "1/2", "3"))
    np.testing.assert_array_equal(found.instants, [0.5, 3, math.pi])
    assert found.origin == "given"


@pytest.mark.parametrize(
    ("A", "rate"),
    [
        ("0", 1),
        ("cos(5*t)", 5),
        ("-3", 3),
        ("-3 + cos(7*t)", 7),
        ("-30 + cos(7*t)", 31),
        ("exp(-t/4)", 1),
    ],
)
def test_the_default_is_20_over_the_fastest_rate(horizon, A, rate):
    found = horizon(text(A))
    assert found.origin == "default"
    assert (found.start, len(found.instants)) == (0, 150)
    # rates are seen at two instants only
    assert found.stop == pytest.approx(20 / rate, rel=0.1 if "cos" in A or "exp" in A else 1e-12)


def test_the_default_follows_the_start(horizon):
    assert horizon(text("-2"), start=5).stop == pytest.approx(15)


@pytest.mark.parametrize("A", ["[[0, 1], [0, 0]]", "[[-2.7, 1], [-7.29, 2.7]]", "[[1, -1], [1, -1]]"])
def test_nilpotent_dynamics_have_no_rate(horizon, A):
    """Their eigenvalues are zero, and 1e-8 by rounding: no reason to look for 10⁹ s."""
    assert horizon(f"states: [x, y]\nA: {A}\nH: [[1, 0]]\n").stop == pytest.approx(20)


def test_nilpotent_dynamics_are_analysed_over_the_default(numeric):
    """Output rows (1, 0) and (−2.7, 1): rank 2."""
    assert numeric("states: [x, y]\nA: [[-2.7, 1], [-7.29, 2.7]]\nH: [[1, 0]]\n").rank == 2


def test_functions_left_open_do_not_set_the_default(horizon):
    """A sample motion is as slow or fast as the interval is long: it cannot say how long that is."""
    found = horizon("functions: [f]\nstates: [x, y]\nA: [[0, f], [0, 0]]\nH: [[1, 0]]\n")
    assert found.stop == pytest.approx(20)


@pytest.mark.parametrize(("n", "count"), [(1, 150), (50, 150), (100, 38), (200, 10), (2000, 10)])
def test_large_systems_get_fewer_instants(n, count):
    assert default_samples(n) == pytest.approx(count, abs=1)


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"times": ("0", "3")}, "the instant 0 is not after the start 0 of the interval"),
        ({"times": ("-1", "3")}, "the instant -1 is not after the start 0"),
        ({"times": ("2", "5"), "start": 4}, "the instant 2 is not after the start 4"),
        ({"start": 5, "stop": 4}, "the interval stops at 4, not after its start 5"),
        ({"stop": 0}, "the interval stops at 0, not after its start 0"),
        ({"stop": "t"}, "the stop of the interval must be a number at the file's values"),
        ({"start": "t"}, "the start of the interval must be a number"),
        ({"times": ("1", "t + 1")}, "an instant of the interval must be a number"),
        ({"stop": "exp(exp(100))"}, "the stop of the interval is not finite"),
    ],
)
def test_what_cannot_be_is_explained(horizon, asked, message):
    with pytest.raises(NotComputableError, match=message):
        horizon(text(), **asked)


@pytest.mark.parametrize(
    ("interval", "asked", "unfit"),
    [
        ("", {"stop": -1}, True),
        ("stop: 3", {"start": 4}, True),
        ("", {"times": ("0",)}, True),
        ("start: 3, stop: 2", {}, False),
        ("start: 3, stop: 2", {"samples": 4}, False),
    ],
)
def test_an_empty_interval_is_the_users_or_the_files(horizon, interval, asked, unfit):
    with pytest.raises(NotComputableError) as error:
        horizon(text(interval=interval), **asked)
    assert isinstance(error.value, UnfitRequestError) == unfit


@pytest.mark.parametrize("asked", [{"stop": "b"}, {"times": ("b",)}])
def test_a_parameter_without_a_value_is_no_number(horizon, asked):
    """A parameter that only the interval uses needs a value too."""
    with pytest.raises(NotComputableError, match="of the interval must be a number at the file's values"):
        horizon(text(extra="parameters: {b: }\n"), **asked)


def test_the_analysis_takes_them(numeric):
    one = numeric(text("-1"), times=("1", "2", "7/2"))
    np.testing.assert_array_equal(one.spaces.instants, [1, 2, 3.5])
    two = numeric(text("-1"), start=1, stop=3, samples=2)
    np.testing.assert_array_equal(two.spaces.instants, [2, 3])
    assert (two.spaces.gramian.starts == 1).all()


def test_the_start_may_be_negative_and_the_interval_far_away(numeric, matrices):
    """x' = 0, y = x: W = t − t0, wherever."""
    for start, stop in ((-5, -2), (1e6, 1e6 + 3), (-1, 2)):
        found = numeric(text(), start=start, stop=stop, samples=3)
        assert found.rank == 1
        W = matrices(found.spaces.gramian)[:, 0, 0]
        np.testing.assert_allclose(W, found.horizon.instants - start, rtol=1e-9)
