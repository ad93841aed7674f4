"""``obscli analyze --dual``: controllability, in its own words, in every format."""

import json

import pytest


CHANNEL = """\
title: An observable combination of outputs
parameters: {g: 9.8, a: -0.5}
states: [alpha, V, output]
inputs: [torque]
disturbances: [w]
dynamics:
  alpha: torque
  V: g*alpha + output
  output: a*output + w
measurements: {speed: V}
"""
BACKWARDS = "states: [x, b]\nA: [[0, 1], [0, exp(-t)]]\nH: [[1, 0]]\nB: [[1], [0]]\n"


@pytest.fixture
def channel(tmp_path):
    file = tmp_path / "channel.yaml"
    file.write_text(CHANNEL)
    return file


def flat(outcome):
    assert outcome.status == 0, outcome.err
    return " ".join(outcome.out.split())


def test_the_report_says_what_inputs_reach(obscli, channel):
    text = flat(obscli("analyze", channel, "--dual"))
    assert "Controllability of (A, B): the observability of the dual system x′ = Aᵀ x, y = Bᵀ x" in text
    assert "Reachable directions (2) direction in time first from order 1 alpha moving torque 0" in text
    assert "Unreachable combinations (1) 1 output: 1" in text
    assert "● reachable 2 alpha V · unreachable 1 output" in text
    assert (
        "✓ stabilizable: what no input moves dies out by itself" in text or "stabilizable iff a < 0" in text
    )
    assert "What to do" not in text


def test_no_section_speaks_of_observability(obscli, channel):
    text = flat(obscli("analyze", channel, "--dual", "--details"))
    report = text.split("an unobservable direction of the dual.")[1].replace("observable and reachable", "")
    report = report.replace("observable and unreachable", "")
    for word in ("observab", "detectable", "no output", "hidden"):
        assert word not in report


def test_names_in_the_file_stay_as_they_are(obscli, channel):
    """The title and the state named `output` are the user's."""
    out = obscli("analyze", channel, "--dual").out
    assert "An observable combination of outputs" in out
    assert "unreachable  1  output" in out


def test_the_data_say_which_matrix(obscli, channel, tmp_path):
    data = json.loads(obscli("analyze", channel, "--dual", "--format", "json").out)
    (result,) = data["results"]
    assert (result["dual"], result["m"]) == ("B", 1)
    assert result["analytic"]["rank"] == 2
    assert result["structure"]["unobservable_dimension"] == 1
    file = tmp_path / "noise.yaml"
    file.write_text(CHANNEL.replace("inputs: [torque]\n", "").replace("torque", "0*g"))
    (result,) = json.loads(obscli("analyze", file, "--dual", "--format", "json").out)["results"]
    assert (result["dual"], result["analytic"]["states"]) == (
        "G",
        {"alpha": "unobservable", "V": "observable", "output": "observable"},
    )
    (result,) = json.loads(obscli("analyze", channel, "--format", "json", "--only", "analytic").out)[
        "results"
    ]
    assert result["dual"] is None


@pytest.mark.parametrize(
    ("a", "verdict"), [("-0.5", "detectable"), ("0.5", "not detectable"), ("0", "not detectable")]
)
def test_what_no_input_moves_dies_out_as_it_does_by_itself(obscli, channel, a, verdict):
    """Stabilizable: the eigenvalues are those of A, not of −A."""
    arguments = ("analyze", channel, "--dual", "--fix", f"a={a}", "--only", "structure", "--format", "json")
    (result,) = json.loads(obscli(*arguments).out)["results"]
    assert result["structure"]["verdict"] == verdict
    words = flat(obscli(*arguments[:-2]))
    assert verdict.replace("detectable", "stabilizable") in words


def test_a_system_in_time_is_reached_but_not_judged(obscli, tmp_path):
    file = tmp_path / "backwards.yaml"
    file.write_text(BACKWARDS)
    text = flat(obscli("analyze", file, "--dual"))
    assert "x′ = −Aᵀ x" in text
    assert "whether what no input moves dies out is not asked of its dual" in text
    assert "Unreachable combinations (1) 1 b: 1" in text
    assert "the Gramian agrees" in text
    (result,) = json.loads(obscli("analyze", file, "--dual", "--format", "json").out)["results"]
    assert result["structure"] is None


def test_a_model_without_inputs_has_no_dual(obscli, integrator, stages):
    found = obscli("analyze", integrator, "--dual")
    assert found.status == 2
    assert "the model has nothing that acts on the states, so no dual: give `B` or `G`" in found.err
    found = obscli("analyze", stages, "--dual", "--stage", "still")
    assert found.status == 2
    assert "stage 'still' has nothing that acts on the states" in found.err


def test_the_cross_check_is_not_about_inputs(obscli, channel):
    found = obscli("analyze", channel, "--dual", "--cross-check")
    assert found.status == 2
    assert "--cross-check" in found.err


def test_a_fix_is_held_against_the_dual_before_it(obscli, channel):
    text = flat(obscli("analyze", channel, "--dual", "--fix", "g=0", "--only", "analytic"))
    assert "The rank goes from 2 to 1. lost V" in text
    assert "reachable direction" in text.lower()
    (result,) = json.loads(
        obscli("analyze", channel, "--dual", "--fix", "g=0", "--only", "analytic", "--format", "json").out
    )["results"]
    (one,) = result["analytic"]["neglect"]
    assert (one["rank_before"], one["rank_after"]) == (2, 1)


@pytest.mark.parametrize("form", ["markdown", "html", "latex"])
def test_every_format_has_the_words(obscli, channel, form):
    found = obscli("analyze", channel, "--dual", "--format", form, "--only", "analytic")
    assert found.status == 0
    assert "Reachable directions" in found.out
