"""Segments on the command line: reports, JSON, verdicts, refusals."""

import json

import pytest


MODEL = """\
title: A cart that is seen at last
parameters: {T: 2}
states: [p, v, b]
dynamics: {p: v, v: b}
stages:
  unseen: {measurements: {y: 0*p}}
  seen: {measurements: {y: p}}
noise: {R: 1e-2, step: 0.5, P0_std: {p: 1, v: 1, b: 1}}
require: {p: 1}
segments:
  - {stage: unseen, name: drive, duration: T, jump: {v: "v + b"}}
  - {stage: seen, name: stop, duration: 3}
expect:
  - {segments: true, rank: 3, determined: all}
"""
HALF = """\
states: [a, b, c]
A: [[0, 0, 0], [0, 0, 0], [0, 0, 0]]
stages: {one: {H: [[1, 1, 0]]}, two: {H: [[1, 1, 0]]}}
segments: [{stage: one, duration: 1}, {stage: two, duration: 1}]
claims:
  - {segments: true, rank: 1, observable: [2*a + 2*b], states: {c: unobservable}, directions: [{a: 1, b: -1}]}
  - {segments: true, at: nominal, rank: 1}
"""


@pytest.fixture
def model(tmp_path):
    def written(text):
        path = tmp_path / "m.yaml"
        path.write_text(text, encoding="utf-8")
        return str(path)

    return written


def test_the_report_names_every_segment_and_what_is_proved(obscli, model):
    outcome = obscli("analyze", model(MODEL), "--segments")
    assert outcome.status == 0
    assert "m · segments" in outcome.out
    assert "drive" in outcome.out
    assert "jump" in outcome.out
    assert "proved: the segments together show 3 of 3 (generic, and at the file's values)" in " ".join(
        outcome.out.split()
    )
    assert "the Gramian over all segments agrees: rank 3" in outcome.out


def test_segments_stand_behind_the_stages(obscli, model):
    out = obscli("analyze", model(MODEL)).out
    assert out.index("m · unseen") < out.index("m · seen") < out.index("m · segments")
    assert "m · segments" not in obscli("analyze", model(MODEL), "--stage", "seen").out


def test_json(obscli, model):
    found = json.loads(obscli("analyze", model(MODEL), "--segments", "--format", "json").out)
    assert found["results"] == []
    whole = found["segments"]
    assert (whole["rank"], whole["generic"], whole["at_least"], whole["at_most"]) == (3, True, 3, 3)
    assert [(one["name"], one["start"], one["stop"], one["jump"], one["rank"]) for one in whole["parts"]] == [
        ("drive", 0.0, 2.0, True, 0),
        ("stop", 2.0, 5.0, False, 3),
    ]
    assert whole["warnings"] == []


@pytest.mark.parametrize("part", ["analytic", "numeric"])
def test_one_part_alone(obscli, model, part):
    out = obscli("analyze", model(MODEL), "--segments", "--only", part).out
    assert ("proved: the segments" in out) == (part == "analytic")
    assert ("the Gramian over all segments has rank 3" in out) == (part == "numeric")


def test_claims_hold(obscli, model):
    for text in (MODEL, HALF):
        outcome = obscli("verify", model(text))
        assert outcome.status == 0, outcome.out
    assert "2*a + 2*b is observable" in outcome.out


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("rank: 1, obs", "rank: 2, obs"),
        ("2*a + 2*b", "a"),
        ("c: unobservable", "c: coupled"),
        ("{a: 1, b: -1}", "{a: 1, b: 1}"),
    ],
)
def test_false_claims_fail(obscli, model, old, new):
    assert obscli("verify", model(HALF.replace(old, new))).status == 1


def test_a_rank_out_of_bounds_fails_where_nothing_is_proved(obscli, model):
    text = """\
states: [a, b]
stages:
  turns: {A: [[0, -1], [1, 0]], H: [[0, 0]]}
  looks: {A: [[0, 0], [0, 0]], H: [[1, 0]]}
segments: [{stage: turns, duration: 1}, {stage: looks, duration: 1}]
claims: [{segments: true, rank: %s}]
"""
    assert "it is proved to be from 1 to 2" in obscli("verify", model(text % 0)).out
    assert "?" in obscli("verify", model(text % 2)).out


def test_simulate_goes_through(obscli, model):
    outcome = obscli("simulate", model(MODEL), "--segments", "--format", "json")
    (found,) = json.loads(outcome.out)["results"]
    assert found["model"]["stage"] == "segments"
    history = found["simulate"]["history"]
    assert history["t"].count(2.0) == 2
    assert history["t"][-1] == 5.0
    assert found["simulate"]["samples"] == 11
    sigma = history["standard_deviation"]
    assert sigma["p"][-1] < 0.2 < history["prior"]["p"]


@pytest.mark.parametrize(
    ("command", "options", "message"),
    [
        ("analyze", ["--segments", "--stage", "seen"], "leave out --stage"),
        ("analyze", ["--segments", "--to", "3"], "leave out --stage, --from"),
        ("simulate", ["--segments", "--to", "3"], "leave out --stage, --from, --to, --filter"),
    ],
)
def test_what_does_not_go_with_segments(obscli, model, command, options, message):
    outcome = obscli(command, model(MODEL), *options)
    assert outcome.status == 2
    assert message in " ".join(outcome.err.split())


@pytest.mark.parametrize("command", ["analyze", "simulate"])
def test_there_have_to_be_segments(obscli, model, command):
    outcome = obscli(command, model("states: [x]\nA: [[0]]\nH: [[1]]\n"), "--segments")
    assert outcome.status == 2
    assert "there are no `segments`" in outcome.err


def test_claims_without_segments_are_reported(obscli, model):
    text = "states: [x]\nA: [[0]]\nH: [[1]]\nclaims: [{segments: true, rank: 1}]\n"
    outcome = obscli("verify", model(text))
    assert outcome.status == 2
    assert "there are no `segments` in this file" in outcome.err


def test_measures_are_those_of_the_end(obscli, model):
    outcome = obscli("measures", model(MODEL), "--segments", "--format", "json")
    (found,) = json.loads(outcome.out)["results"]
    (simulated,) = json.loads(obscli("simulate", model(MODEL), "--segments", "--format", "json").out)[
        "results"
    ]
    history = simulated["simulate"]["history"]["standard_deviation"]
    end = found["measures"]
    for state in ("p", "v", "b"):
        assert end["states"][state]["standard-deviation"] == pytest.approx(history[state][-1])
    assert "one of the system in force" in outcome.out


def test_the_gramian_measured_is_that_of_the_whole_way(obscli, model):
    """Looking at p alone for 3 from p(2), v(2), b: singular values do not know what went before."""
    looks = "states: [p, v, b]\ndynamics: {p: v, v: b}\nmeasurements: {y: p}\ninterval: {start: 2, stop: 5}\n"
    options = ("--select", "gramian-singular-values", "--format", "json")
    (one,) = json.loads(obscli("measures", model(MODEL), "--segments", *options).out)["results"]
    (other,) = json.loads(obscli("measures", model(looks), *options).out)["results"]
    values = [
        [k["value"] for k in of["measures"]["system"]["gramian-singular-values"]] for of in (one, other)
    ]
    assert values[0] == pytest.approx(values[1], rel=1e-9)


MANOEUVRES = """\
states: [p, q, r]
stages:
  wait: {A: [[0, 0, 0], [0, 0, 0], [0, 0, 0]], H: [[0, 0, 0]]}
  drive: {A: [[0, 1, 0], [0, 0, 0], [0, 0, 0]], H: [[0, 0, 0]]}
  turn: {A: [[0, 0, 1], [0, 0, 0], [0, 0, 0]], H: [[1, 0, 0]]}
  look: {A: [[0, 0, 0], [0, 0, 0], [0, 0, 0]], H: [[1, 0, 0]]}
segments:
  - {stage: wait, duration: 5}
  - {stage: turn, duration: 2}
  - {stage: wait, name: again, duration: 5}
  - {stage: drive, duration: 1}
  - {stage: look, duration: 1}
"""


def test_plan_finds_the_shortest_order(obscli, model):
    """The turn shows p and r as it goes, or p + q and r after the drive; q needs a look on either side of it."""
    outcome = obscli("plan", model(MANOEUVRES), "--segments", "--format", "json")
    orders = json.loads(outcome.out)["orders"]
    assert (orders["rank"], orders["target"], orders["complete"]) == (3, 3, True)
    assert [one["segments"] for one in orders["best"]] == [
        ["turn", "drive", "look"],
        ["look", "drive", "turn"],
    ]
    assert [(one["duration"], one["at_least"]) for one in orders["best"]] == [
        (4.0, [2, 2, 3]),
        (4.0, [1, 1, 3]),
    ]
    assert "proved: 3 of 3 are shown by 3 segments" in obscli("plan", model(MANOEUVRES), "--segments").out


def test_plan_leaves_out_what_would_turn_in_no_time(obscli, model):
    """Standing at 0 and at pi/2 is an order only by way of the turn."""
    text = """\
parameters: {a: 0, w: 0.1}
states: [tilt, bias, rest]
let: {R: rotz(a)}
dynamics: {tilt: "R[1,1]*bias"}
measurements: {y: "R[1,1]*tilt + R[2,1]*rest"}
stages: {stands: {}, turns: {let: {R: rotz(a + w*t)}, measurements: {y: 0*tilt}}}
segments:
  - {stage: turns, name: turn, duration: pi/2/w, fix: {a: 0}}
  - {stage: stands, name: end, duration: 1, fix: {a: pi/2}}
  - {stage: stands, name: first, duration: 1, fix: {a: 0}}
"""
    orders = json.loads(obscli("plan", model(text), "--segments", "--format", "json").out)["orders"]
    assert [one["segments"] for one in orders["best"]] == [["first", "turn", "end"]]


def test_plan_does_not_move_jumps(obscli, model):
    outcome = obscli("plan", model(MODEL), "--segments")
    assert outcome.status == 2
    assert "the jump after drive is one between two segments" in " ".join(outcome.err.split())


OFTEN = """\
states: [p]
functions: [f]
A: [[f]]
H: [[1]]
noise: {R: 1, P0_std: 1}
stages:
  slow: {outputs: {y1: {every: 2}}}
  quick: {outputs: {y1: {every: 0.5, during: [[0, 14], [17, 30]]}}}
  dense: {}
segments: [{stage: slow, duration: 10}, {stage: quick, duration: 10}, {stage: slow, name: again, duration: 5.5}]
"""


def test_outages_are_judged_by_the_step_of_each_segment(obscli, model):
    outcome = obscli("simulate", model(OFTEN), "--segments")
    assert "every 0.5 to 2; none in 14 … 17" in outcome.out
    assert "functions left open" in outcome.out
    found = json.loads(obscli("simulate", model(OFTEN), "--segments", "--format", "json").out)
    (output,) = found["results"][0]["simulate"]["outputs"]
    assert (output["every"], output["longest"]) == (0.5, 2.0)
    assert output["outages"] == [{"start": 14.0, "stop": 17.0}]


def test_a_step_that_is_assumed_in_a_later_segment_is_told(obscli, model):
    text = OFTEN.replace("again, duration: 5.5}", "again, duration: 5.5}, {stage: dense, duration: 4.5}")
    text = text.replace("functions: [f]", "parameters: {f: 0.1}")
    for command in ("simulate", "measures"):
        out = " ".join(obscli(command, model(text), "--segments").out.split())
        assert "0.075 is taken (--step)" in out


def test_measures_of_segments_have_figures_against_time(obscli, model, tmp_path):
    assert obscli("measures", model(MODEL), "--segments", "--plot", tmp_path / "figures").status == 0
    names = {one.name for one in (tmp_path / "figures").glob("*.svg")}
    assert names == {"m_segments-stochastic.svg", "m_segments-deviation.svg"}


def test_an_interrupt_in_the_segments_keeps_the_stages(obscli, model, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("obscli.pipelines.simulate_segments.segment_history", interrupted)
    outcome = obscli("simulate", model(MODEL.replace("0*p", "v")))
    assert outcome.status == 130
    assert "m · unseen" in outcome.out
    assert "m · seen" in outcome.out


def test_a_duration_that_is_none_at_these_values_is_refused_everywhere(obscli, model):
    for command in (("analyze", "--only", "analytic"), ("simulate",), ("verify",)):
        outcome = obscli(command[0], model(MODEL), *command[1:], "--set", "T=1-sqrt(5)")
        assert outcome.status == 2
        assert "segments[1].duration: a positive duration is expected here; T is not" in outcome.err


OTHERS = """\
states: [x, v]
dynamics: {x: v}
noise: {P0_std: [1, 1], step: 0.25}
interval: {start: 0, stop: 1}
stages:
  both: {measurements: {y: x, z: v}, noise: {R: {y: 0.01, z: 0.04}}}
  place: {measurements: {y: x}, noise: {R: {y: 0.01}}}
  speed: {measurements: {z: v}, noise: {R: {z: 0.04}}}
segments: [{stage: %s, name: one, duration: 1}, {stage: place, name: two, duration: 1}, {stage: speed, duration: 1}]
"""


@pytest.mark.parametrize(("first", "z"), [("both", "1 … 2.25"), ("place", "0 … 2.25")])
def test_outputs_of_segments_are_told_by_name(obscli, model, first, z):
    outcome = obscli("simulate", model(OTHERS % first), "--segments")
    assert outcome.status == 0
    assert "y every 0.25; none in 2 … 3" in " ".join(outcome.out.split())
    assert f"z every 0.25; none in {z}" in " ".join(outcome.out.split())


@pytest.mark.parametrize("duration", ["0.3", "0.6", "0.7", "2.3"])
def test_a_sample_at_the_end_is_taken_before_the_jump_whatever_rounding_does(obscli, model, duration):
    """The same in units of time ten times as short."""
    text = (
        "states: [x, v]\nA: [[0, %s], [0, 0]]\nH: [[1, 0]]\noutputs: {y1: {every: %s}}\nnoise: {R: 0.01, P0_std: 1}\n"
        "stages: {s: {}}\nsegments: [{stage: s, duration: %s, jump: {x: x + v}}, {stage: s, name: b, duration: %s}]\n"
    )
    found = []
    for values in (("1", "0.1", duration, "0.3"), ("1/10", "1", f"10*{duration}", "3")):
        outcome = obscli("simulate", model(text % values), "--segments", "--format", "json")
        found.append(json.loads(outcome.out)["results"][0]["simulate"])
    one, ten = found
    assert one["samples"] == ten["samples"]
    assert [10 * t for t in one["history"]["t"]] == pytest.approx(ten["history"]["t"])
    for name, sigma in one["history"]["standard_deviation"].items():
        assert sigma == pytest.approx(ten["history"]["standard_deviation"][name], rel=1e-9)


def test_what_a_later_segment_lacks_is_told_with_its_name(obscli, model):
    text = (OTHERS % "both").replace("noise: {R: {z: 0.04}}}\nseg", "}\nseg")
    outcome = obscli("simulate", model(text), "--segments")
    assert outcome.status == 2
    assert "segment speed: `noise` is not complete: give the noise of z" in " ".join(outcome.out.split())


def test_the_gramian_of_segments_in_discrete_time_is_read_at_the_end(obscli, model):
    text = "states: [x, v]\nstages: {a: {F: [[1, 1], [0, 1]], H: [[1, 0]]}}\nsegments: [{stage: a, duration: 5}]\n"
    out = " ".join(obscli("measures", model(text), "--segments").out.split())
    assert "of each direction at the end of the segments" in out


def test_segments_in_discrete_time_begin_and_end_at_whole_steps(obscli, model):
    text = (
        "states: [x, v]\nstages: {a: {F: [[1, 1], [0, 1]], H: [[1, 0]]}}\ninterval: {start: 0.5}\n"
        "segments: [{stage: a, duration: 4.5}]\n"
    )
    for command in ("analyze", "measures"):
        out = " ".join(obscli(command, model(text), "--segments").out.split())
        assert "the start of the segments is 0.5: a discrete-time model counts steps, whole numbers" in out
