"""What models/calibration claims agrees with a route that shares nothing with obscli."""

import importlib.util
import re
from collections import Counter
from itertools import combinations
from pathlib import Path

import pytest


_spec = importlib.util.spec_from_file_location(
    "calibration_claims", Path(__file__).parent / "calibration_claims.py"
)
claims = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(claims)
LEVEL, PLAN, TWO_AXES = "paper, axis level", "table_plan", "two_axis_table"


def _labels(model):
    return list(claims.EXPERIMENTS[model][2])


def _rank(model, runs):
    return len(claims.together(model, runs)[0])


def _ranks(model, runs, size):
    return Counter(_rank(model, some) for some in combinations(runs, size))


def test_claims_and_expectations_agree():
    wrong, compared = claims.check()
    assert wrong == []
    assert compared >= 30


@pytest.mark.parametrize(
    ("size", "ranks"),
    [(1, {13: 6}), (2, {15: 3, 20: 12}), (3, {21: 20}), (4, {21: 15}), (5, {21: 6}), (6, {21: 1})],
)
def test_the_papers_six_level_runs(size, ranks):
    assert _ranks(LEVEL, _labels(LEVEL), size) == ranks


def test_the_papers_vertical_axis():
    up = [f"{axis}_turns (outer = 0{way})" for axis in "xyz" for way in ("", ", omega = -omega")]
    down = [label.replace("outer = 0", "outer = pi") for label in up]
    assert _rank(PLAN, up[::2]) == _rank(PLAN, up) == 18
    assert _rank(PLAN, up[::2] + down[::2]) == 21


def test_no_two_of_the_candidates_suffice():
    assert _ranks(PLAN, _labels(PLAN), 2) == {12: 6, 13: 6, 15: 72, 18: 96, 19: 48, 20: 48}


def test_two_runs_of_the_two_axis_table_suffice_in_twenty_ways():
    hanging = re.compile(r".*outer = pi\b[),]")
    assert _ranks(TWO_AXES, [one for one in _labels(TWO_AXES) if not hanging.match(one)], 2)[21] == 20
