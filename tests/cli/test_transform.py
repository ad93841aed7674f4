"""``obscli transform``: models made of models, read back, and what is said of them."""

import json

import pytest

from obscli.model.library import bundled_models
from obscli.model.reader import load


#: A tilt that only shows together with a bias, which nothing moves.
TILT = """\
title: "A tilt: with a bias"
parameters: {g: {value: 9.81, unit: m/s^2, assume: positive}, w: 0.1}
states:
  tilt: {unit: rad, description: tilt, scale: 0.001}
  bias: {unit: m/s^2}
  drift: {unit: rad/s}
A: {tilt: {drift: 1}, drift: {drift: -w}}
H: {y: {tilt: g, bias: -1}}
disturbances: [n]
G: {drift: {n: 1}}
noise: {Q: 1e-6, R: 0.01, P0_std: [0.1, 0.02, 0.001]}
quantities: {apparent: tilt - bias/g, sum: tilt + bias}
interval: {start: 0, stop: 600}
"""
#: x is moved by a state that no output shows beside it; nothing can be dropped without loss.
MOVED = """\
states: [x, b]
A: [[-tan(t), 1], [0, 0]]
H: [[1, 0]]
stages: {seen: {}, hidden: {H: [[0, 0]]}}
"""


@pytest.fixture
def tilt(tmp_path):
    file = tmp_path / "tilt.yaml"
    file.write_text(TILT)
    return file


def transformed(obscli, *arguments):
    outcome = obscli("transform", *arguments, "--format", "json")
    assert outcome.status == 0, outcome.err
    return [one["transform"] for one in json.loads(outcome.out)["results"]]


@pytest.mark.parametrize(
    ("name", "target"),
    [
        *((name, "observable") for name in sorted(bundled_models())),
        *(
            (name, "drop")
            for name in sorted(bundled_models())
            if name.startswith(("textbook", "bagmut", "ins"))
        ),
        ("kortunov/sixteen_states_case_3", "drop"),
    ],
)
def test_bundled_models_in_every_stage(obscli, name, target):
    file = bundled_models()[name]
    option = ["--drop"] if target == "drop" else ["--to", target]
    outcome = obscli("transform", file, *option, "--format", "json")

    assert outcome.status == 0, outcome.err
    results = json.loads(outcome.out)["results"]
    assert len(results) == len(load(file).systems)
    for result in results:
        made = result["transform"]
        if not made["n"]:
            assert made["reason"] == "no combination of the states is observable"
            continue
        assert made["reason"] == ""
        assert all(check["verdict"] == "holds" for check in made["checks"])
        assert f"rank {made['n']} of {made['n']}, proved anew" in [
            check["reason"] for check in made["checks"]
        ]
        assert made["n"] == len(made["variables"]) == len(made["A"])
        assert made["n"] + len(made["left_out"]) == result["n"]
        assert len(made["H"]) == result["m"]
        assert len({one["name"] for one in made["variables"]}) == made["n"]


@pytest.mark.parametrize(
    ("name", "stage", "dimensions"),
    [
        ("kortunov/single_channel", None, [0, 5, 0, 0]),
        ("kortunov/accelerometer_only", None, [0, 3, 0, 1]),
        ("kortunov/sixteen_states_case_2", "velocity_position", [0, 16, 0, 0]),
        ("kortunov/sixteen_states_case_3", "velocity_position", [3, 13, 0, 0]),
        ("kortunov/sixteen_states_case_3", "with_heading", [2, 14, 0, 0]),
        ("bagmut/gyro", "attitude", [2, 1]),
        ("ins_calibration/horizontal", "stage_3", [16, 8]),
        ("calibration/six_position", "levelled", [9, 9]),
    ],
)
def test_kalman(obscli, name, stage, dimensions, tmp_path):
    file, target = bundled_models()[name], tmp_path / "kalman.yaml"
    chosen = [] if stage is None else ["--stage", stage]
    [made] = transformed(obscli, file, "--to", "kalman", *chosen, "-o", target)

    assert made["dimensions"] == dimensions
    assert made["n"] == sum(dimensions)
    assert made["inputs"] == ("G" if len(dimensions) == 4 else None)
    assert all(check["verdict"] == "holds" for check in made["checks"])
    written = load(target).systems[0]
    assert list(written.state_names) == [one["name"] for one in made["variables"]]
    outcome = obscli("analyze", target, "--only", "structure", "--format", "json")
    structure = json.loads(outcome.out)["results"][0]["structure"]
    assert structure["unobservable_dimension"] == (
        dimensions[1] if len(dimensions) == 2 else dimensions[0] + dimensions[2]
    )


def test_the_model_is_written_with_all_that_carries_over(obscli, tilt, tmp_path):
    target = tmp_path / "reduced.yaml"
    [made] = transformed(obscli, tilt, "--to", "observable", "-o", target)

    assert [one["name"] for one in made["variables"]] == ["z_tilt", "drift"]
    assert made["variables"][0]["coefficients"] == {"tilt": "g", "bias": "-1"}
    assert made["variables"][0]["meaning"] == "g*tilt - bias"
    assert made["A"] == {"z_tilt": {"drift": "g"}, "drift": {"drift": "-w"}}
    assert made["H"] == {"y": {"z_tilt": "1"}}
    assert made["back"]["tilt"] == {"z_tilt": "1/g", "bias": "1/g"}
    assert made["left_out"] == ["bias"]
    model = load(target)
    [system] = model.systems
    assert model.title == "A tilt: with a bias (observable part)"
    assert [one.unit for one in system.states] == ["", "rad/s"]
    assert [one.name for one in system.quantities] == ["apparent"]
    assert {one.name for one in system.parameters} == {"g", "w"}
    assert system.disturbances == ("n",)
    assert len(system.noise.P0.entries) == 2
    text = target.read_text()
    assert "#   tilt = 1/g*z_tilt + 1/g*bias" in text
    assert "sum (quantities)" in text
    assert obscli("verify", target).status == 0
    assert (
        json.loads(obscli("analyze", target, "--format", "json").out)["results"][0]["analytic"]["rank"] == 2
    )


def test_dropping_says_what_it_assumes(obscli, tilt, tmp_path):
    target = tmp_path / "dropped.yaml"
    outcome = obscli("transform", tilt, "--drop", "-o", target)

    assert outcome.status == 0
    assert "Assumes bias = 0" in outcome.out
    assert "tilt - 1/g*bias" in outcome.out
    assert "sum (quantities)" in outcome.out
    [system] = load(target).systems
    assert system.state_names == ("tilt", "drift")
    assert [one.description for one in system.states] == ["tilt", ""]
    assert "#   tilt: tilt - 1/g*bias" in target.read_text()


def test_dropping_that_loses_something_says_so(obscli, tmp_path):
    file = tmp_path / "moved.yaml"
    file.write_text("states: [x, b, c]\nA: [[0, 1, 0], [0, 0, 0], [1, 0, 0]]\nH: [[1, 0, 1]]\n")
    [made] = transformed(obscli, file, "--drop", "--pivot-order", "x,b,c")
    assert made["exact"] in {True, False}
    moving = tmp_path / "turning.yaml"
    moving.write_text("states: [x, y]\nA: [[0, -1], [1, 0]]\nH: [[cos(t), sin(t)]]\n")
    [made] = transformed(obscli, moving, "--drop")
    assert (made["exact"], made["left_out"], made["moved"]) == (False, ["y"], ["y"])
    outcome = obscli("transform", moving, "--drop")
    assert "they do not stay zero" in outcome.out or "do not stay zero: y" in outcome.out


def test_nothing_observable_leaves_no_model(obscli, tmp_path):
    file, target = tmp_path / "moved.yaml", tmp_path / "none.yaml"
    file.write_text(MOVED)
    for option in (["--to", "observable"], ["--drop"]):
        outcome = obscli("transform", file, *option)
        assert outcome.status == 0
        assert "no combination of the states is observable" in outcome.out
        outcome = obscli("transform", file, *option, "--stage", "hidden", "-o", target)
        assert outcome.status == 1
        assert "nothing is written" in outcome.err
        assert not target.exists()
    outcome = obscli("transform", file, "--to", "kalman", "--stage", "hidden", "-o", target)
    assert outcome.status == 0
    assert load(target).systems[0].n == 2


def test_undecided_is_said_and_counts_where_a_decision_is_required(obscli, tmp_path):
    file, target = tmp_path / "open.yaml", tmp_path / "none.yaml"
    file.write_text("parameters: {a: 1}\nstates: [x]\nA: [[0]]\nH: [[sqrt(a^2)]]\n")
    outcome = obscli("transform", file, "--to", "observable")
    assert outcome.status == 0
    assert "undecided" in outcome.out
    assert obscli("transform", file, "--to", "observable", "--strict").status == 4
    assert obscli("transform", file, "--to", "observable", "-o", target).status == 4
    assert not target.exists()


def test_one_model_is_written_at_a_time(obscli, tmp_path):
    file = bundled_models()["ins_calibration/horizontal"]
    outcome = obscli("transform", file, "--to", "observable", "-o", tmp_path / "x.yaml")
    assert outcome.status == 2
    assert "choose the stage with --stage NAME: stage_1, stage_2, stage_3" in outcome.err
    assert not (tmp_path / "x.yaml").exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "say what to make"),
        (["--to", "kalman", "--drop"], "say what to make"),
        (["--to", "kalmann"], "is not one of observable, kalman"),
        (["--drop", "--basis", "sparse"], "is about --to observable"),
        (["--to", "observable", "--stage", "x"], "no stage 'x'"),
        (["--to", "observable", "--pivot-order", "tlit"], "did you mean 'tilt'"),
    ],
)
def test_wrong_usage(obscli, tilt, arguments, message):
    outcome = obscli("transform", tilt, *arguments)
    assert outcome.status == 2
    assert message in outcome.err
    assert outcome.out == ""


def test_changes_are_made_before_and_recorded(obscli, tilt, tmp_path):
    target = tmp_path / "changed.yaml"
    outcome = obscli(
        "transform",
        tilt,
        "--to",
        "observable",
        "--fix",
        "w=0",
        "--set",
        "g=10",
        "--without",
        "drift",
        "-o",
        target,
    )
    assert outcome.status == 0
    assert "# Changed before: --set g=10 --fix w=0 --without drift" in target.read_text()
    [system] = load(target).systems
    assert system.state_names == ("z_tilt",)


def test_sparse_basis_and_pivot_order(obscli, tilt):
    [made] = transformed(obscli, tilt, "--to", "observable", "--basis", "sparse")
    assert sorted(len(one["coefficients"]) for one in made["variables"]) == [1, 2]
    [made] = transformed(obscli, tilt, "--to", "observable", "--pivot-order", "bias")
    assert made["left_out"] == ["tilt"]
    assert made["back"]["bias"] == {"z_tilt": "-1", "tilt": "g"}


@pytest.mark.parametrize("form", ["terminal", "markdown", "latex", "html"])
@pytest.mark.parametrize("option", ["--to=observable", "--to=kalman", "--drop"])
def test_every_format_has_it(obscli, tilt, form, option):
    outcome = obscli("transform", tilt, option, "--format", form)
    assert outcome.status == 0
    assert "drift" in outcome.out
    assert outcome.err == ""


def test_numbers_of_many_digits_are_rounded_for_the_reader_only(obscli, tmp_path):
    file, target = tmp_path / "digits.yaml", tmp_path / "out.yaml"
    file.write_text(
        "states: [a, b, c]\nA: [[0.123456789123, 0.3, 1], [0.987654321987, 0.1, 2], [0, 0, 0]]\nH: [[1.23456789, 1, 0]]\n"
    )
    [made] = transformed(obscli, file, "--to", "observable", "-o", target)
    exact = load(target).systems[0]
    assert len(made["A"]["a"]) <= 3
    assert exact.n == made["n"]
    outcome = obscli("transform", file, "--to", "observable")
    assert max(len(word) for word in outcome.out.split()) < 60
