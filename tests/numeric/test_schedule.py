"""When outputs are sampled, and with what covariance."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from obscli.model.expression import number
from obscli.numeric.errors import NotComputableError
from obscli.numeric.schedule import schedule_of


TWO = "states: [x, y]\nA: zeros(2, 2)\nmeasurements: {{a: x, b: y}}\nnoise: {{R: {R}{more}, P0_std: 1}}\n"


def constant(value):
    return number(Fraction(value))


@pytest.fixture
def two(system):
    """Two outputs, each with what is asked for its sampling."""

    def made(R="{a: 4, b: 9}", more="", **outputs):
        given = system(TWO.format(R=R, more=more))
        return replace(given, outputs=tuple(_sampled(one, outputs.get(one.name)) for one in given.outputs))

    return made


def _sampled(output, asked):
    if asked is None:
        return output
    every, *during = asked
    return replace(
        output,
        every=None if every is None else constant(every),
        during=tuple((constant(a), constant(b)) for a, b in during) or None,
    )


def test_a_step_of_the_noise_makes_r_the_covariance_of_a_sample(two):
    found = schedule_of(two(more=", step: 0.1"), 2, 3)
    assert found.t == pytest.approx(2 + 0.1 * np.arange(11))
    assert found.sampled.all()
    assert pytest.approx(np.diag([4, 9])) == found.R
    assert (found.assumed_step, found.samples) == (None, 22)


def test_a_density_is_divided_by_the_step_whether_assumed_or_asked_for(two):
    assumed = schedule_of(two(), 0, 200)
    assert (assumed.assumed_step, len(assumed.t)) == (0.5, 401)
    assert pytest.approx(np.diag([8, 18])) == assumed.R
    asked = schedule_of(two(), 0, 200, step=2)
    assert (asked.assumed_step, len(asked.t)) == (None, 101)
    assert pytest.approx(np.diag([2, 4.5])) == asked.R


def test_a_step_asked_for_takes_samples_less_often_but_not_from_outputs_with_their_own(two):
    found = schedule_of(two(more=", step: 0.1", a=(0.5,)), 0, 4, step=2)
    assert found.t == pytest.approx(0.5 * np.arange(9))
    assert found.sampled[:, 0].all()
    assert found.t[found.sampled[:, 1]] == pytest.approx([0, 2, 4])
    assert pytest.approx(np.diag([4, 9])) == found.R


def test_instants_that_agree_to_rounding_are_one(two):
    found = schedule_of(two(a=(0.1,), b=(0.3,)), 0, 30)
    assert len(found.t) == 301
    assert np.flatnonzero(found.sampled[:, 1]) == pytest.approx(3 * np.arange(101))


def test_outages_are_closed_intervals(two):
    found = schedule_of(two(a=(1, (0, 2), (5, 6.5)), b=(3,)), 0, 9)
    assert found.t[found.sampled[:, 0]] == pytest.approx([0, 1, 2, 5, 6])
    assert found.t == pytest.approx([0, 1, 2, 3, 5, 6, 9])
    assert found.samples == 5 + 4


def test_an_output_with_its_own_rate_beside_a_density(two):
    found = schedule_of(two(a=(5,)), 0, 20, step=2)
    assert pytest.approx(np.diag([4, 4.5])) == found.R


def test_a_shift_of_time_shifts_the_samples(two):
    given = two(a=(0.7,), b=(0.2,))
    here, there = schedule_of(given, 0, 10), schedule_of(given, 1000, 1010)
    assert there.t - 1000 == pytest.approx(here.t)
    assert (there.sampled == here.sampled).all()


@pytest.mark.parametrize(
    ("options", "interval", "step", "reason"),
    [
        ({"a": (1, (50, 60)), "b": (1, (70, 80))}, (0, 10), None, "no output has a sample"),
        ({"more": ", step: 1e-9"}, (0, 10), None, "at the most"),
        ({}, (0, 10), 0, "must be positive"),
        ({"a": (0,)}, (0, 10), None, "must be positive"),
        ({}, (3, 3), None, "is empty"),
        ({"R": "{a: 1}"}, (0, 10), None, "no R, or zero, for b"),
        ({"R": "[[4, 1], [1, 9]]", "a": (1,)}, (0, 10), None, "correlates a and b"),
    ],
)
def test_what_cannot_be_sampled_is_refused_with_its_reason(two, options, interval, step, reason):
    with pytest.raises(NotComputableError, match=reason):
        schedule_of(two(**options), *interval, step)
