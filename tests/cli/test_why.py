"""``obscli why`` as a user meets it."""

import json

import pytest


TABLE = """\
title: A turntable
parameters: {g: 9.81, omega: 0.1}
states: [tilt, bias, drift, scale]
dynamics: {tilt: drift + omega*scale}
measurements: {y: g*tilt - bias}
quantities: {rate: drift + omega*scale}
noise: {R: 1e-4, step: 1, P0_std: {tilt: 1e-3, bias: 1e-2, drift: 1e-5, scale: 1e-4}}
interval: {stop: 100}
stages: {turning: {}, still: {fix: {omega: 0}}}
"""


@pytest.fixture
def put(tmp_path, monkeypatch):
    """Write a file into a directory of its own, from which the commands are run."""
    monkeypatch.chdir(tmp_path)
    return lambda name, text: (tmp_path / name).write_text(text)


@pytest.fixture(autouse=True)
def _table(put):
    put("table.yaml", TABLE)


def why(obscli, *arguments):
    return json.loads(obscli("why", *arguments, "--format", "json").out)["results"]


def test_a_state_is_explained_on_one_screen_of_80_columns(obscli, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    outcome = obscli("why", "table.yaml", "drift", "--stage", "turning")
    lines = outcome.out.splitlines()
    assert (outcome.status, outcome.err) == (0, "")
    assert len(lines) <= 24
    assert max(map(len, lines)) <= 80
    assert "✗ coupled: the outputs determine it only together with other states" in outcome.out
    assert "- drift + omega*scale (y, order 1)" in outcome.out
    assert "- drift: omega, scale: -1" in outcome.out
    assert "Its hidden error is neutral (eigenvalue 0)." in outcome.out
    assert "- measured as well: drift (rank 3), scale (rank 3)" in outcome.out
    assert "- in another stage: still (rank 2)" in outcome.out


def test_a_fix_undone_is_tried(obscli):
    [still] = why(obscli, "table.yaml", "drift + scale/10", "--stage", "still", "--only", "analytic")
    assert still["why"]["verdict"] == "coupled"
    [scale] = why(obscli, "table.yaml", "scale", "--stage", "still", "--only", "analytic")
    assert scale["why"]["verdict"] == "unobservable"
    assert [one["kind"] for one in scale["why"]["conditions"]] == ["output"]
    [rate] = why(obscli, "table.yaml", "rate", "--stage", "turning", "--fix", "omega=1/10")
    assert rate["why"]["verdict"] == "observable"


def test_a_state_that_a_fix_hides_comes_back_without_it(obscli, put):
    put("fixed.yaml", TABLE.replace("tilt: drift + omega*scale", "tilt: drift, drift: omega*scale"))
    [scale] = why(obscli, "fixed.yaml", "scale", "--stage", "still", "--only", "analytic")
    changes = {(one["kind"], one["change"]) for one in scale["why"]["conditions"]}
    assert {("fix", "omega free"), ("stage", "turning"), ("output", "scale")} <= changes


def test_quantities_vectors_and_combinations_are_targets(obscli, put):
    put("vector.yaml", "states: {x: 2}\nA: zeros(2, 2)\nH: [[1, 0]]\nquantities: {q: x1 + x2}\n")
    assert [one["why"]["target"] for one in why(obscli, "vector.yaml", "x")] == ["x1", "x2"]
    assert [one["why"]["verdict"] for one in why(obscli, "vector.yaml", "x")] == [
        "observable",
        "unobservable",
    ]
    assert why(obscli, "vector.yaml", "q")[0]["why"]["coefficients"] == {"x1": "1", "x2": "1"}
    assert why(obscli, "vector.yaml", "x1 - 2*x2")[0]["why"]["verdict"] == "coupled"


def test_numbers_say_how_well_and_what_limits(obscli):
    [found] = why(obscli, "table.yaml", "drift", "--stage", "turning")
    told = found["why"]
    assert told["deviation"]["start"] == pytest.approx(1e-5)
    assert told["deviation"]["end"] <= 1e-5
    assert told["floor"] in {"P0", "R", "none"}
    assert {one["state"] for one in told["partners"]} <= {"tilt", "bias", "scale"}
    [bare] = why(obscli, "table.yaml", "drift", "--stage", "turning", "--only", "analytic")
    assert bare["why"]["deviation"] is None


@pytest.mark.parametrize(
    ("target", "message"),
    [
        ("drfit", "did you mean 'drift'?"),
        ("tilt*bias", "not linear"),
        ("1", "a term without a state"),
        ("tilt +", "expected"),
    ],
)
def test_what_is_no_combination_is_refused_with_its_place(obscli, target, message):
    outcome = obscli("why", "table.yaml", target)
    assert outcome.status == 2
    assert outcome.out == ""
    assert message in outcome.err
    assert "TARGET:1:" in outcome.err
