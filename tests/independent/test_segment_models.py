"""What models/segments expects agrees with a route that shares nothing with obscli."""

import importlib.util
from pathlib import Path

import pytest

from obscli import api
from obscli.model.library import bundled_model
from obscli.pipelines.request import AnalyzeRequest, Changes


_spec = importlib.util.spec_from_file_location("segment_ranks", Path(__file__).parent / "segment_ranks.py")
route = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(route)


@pytest.mark.parametrize(
    ("name", "motion", "earth", "expected"),
    [
        ("two_axis_jumps", "jumps", route.OMEGA, 24),
        ("two_axis_jumps", "jumps", 0.0, 18),
        ("two_axis_turns", "turns", route.OMEGA, 24),
        ("two_axis_turns", "turns", 0.0, 20),
    ],
)
def test_ranks(name, motion, earth, expected):
    fix = {} if earth else {"omega_ie": "0"}
    found = api.analyze(
        bundled_model(name), request=AnalyzeRequest(segments=True), changes=Changes(fix=fix)
    ).segments
    number, values = route.rank(route.rows(motion=motion, earth=earth))
    assert number == found.rank == found.seen == expected
    assert values[expected - 1] > 1e-4 * values[0]


def test_without_the_motion_all_seems_observable():
    """The bare positions: 24 of 24 with the rate of the Earth, which the warning says is not to be believed."""
    assert route.rank(route.rows(motion="none"))[0] == 24
    assert route.rank(route.rows(motion="none", earth=0.0))[0] == 14
