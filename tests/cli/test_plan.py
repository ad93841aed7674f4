"""``obscli plan``: exit codes, options, formats, JSON, figures, and models at the edge."""

import json

import pytest


TABLE = """\
title: A small table
parameters: {w: 2, g: 10}
states: {x: {unit: rad}, b: {unit: rad/s}, m: {unit: rad}, u: 1}
dynamics: {x: b + w*m}
measurements: {y: x, z: u/g}
noise: {R: {y: 1e-4, z: 1e-2}, P0_std: {x: 1, b: 1, m: 1, u: 5}}
interval: {stop: 20, samples: 10}
require: {b: 0.01, m: 0.01, u: 1}
experiment:
  name: both_ways
  runs: [{name: there}, {name: back, fix: {w: -w}}]
plan:
  setup_time: 5
  candidates: [{name: there}, {name: back, fix: {w: -w}}, {name: still, fix: {w: 0}}]
"""


@pytest.fixture
def plan(obscli, tmp_path):
    """Run ``obscli plan`` on a model text."""

    def run(text, *arguments):
        file = tmp_path / "table.yaml"
        file.write_text(text)
        return obscli("plan", file, *arguments)

    return run


@pytest.fixture
def result(plan):
    """Return the one result in JSON."""

    def run(text, *arguments, status=0):
        outcome = plan(text, "--format", "json", *arguments)
        assert (outcome.status, outcome.err) == (status, "")
        [found] = json.loads(outcome.out)["results"]
        return found

    return run


def sets(found):
    return {frozenset(one["runs"]) for one in found["plan"]["sets"]}


# -- exit codes


def test_all_well_is_0(plan):
    outcome = plan(TABLE, "--strict")

    assert (outcome.status, outcome.err) == (0, "")
    assert outcome.out.startswith("table · plan\n")
    assert plan(TABLE[: TABLE.index("plan:")]).out.startswith("table · both_ways · plan\n")


def test_what_no_plan_meets_is_1(plan):
    """Two runs of nothing but x: u is never seen."""
    assert plan(TABLE, "--outputs", "y").status == 1
    assert plan(TABLE, "--outputs", "y", "--strict").status == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--run", "bakc"), "no run 'bakc'; did you mean 'back'?"),
        (("--only", "analytic"), "No such option"),
        (("--no-critical",), "No such option"),
        (("--format", "paper"), "terminal, json, markdown, latex, html"),
        (("--set", "omega=1"), "'omega' is no parameter"),
        (("--fix", "w=omega"), "unknown name 'omega'"),
        (("--without", "y"), "'y' is no state"),
        (("--outputs", "b"), "'b' is no output"),
        (("--samples", "0"), "greater than or equal to 1"),
        (("--scaling", "unit"), "automatic, scale, prior, none"),
    ],
)
def test_what_cannot_be_asked_is_2_and_prints_nothing(plan, arguments, message):
    outcome = plan(TABLE, *arguments)

    assert (outcome.status, outcome.out) == (2, "")
    assert message in " ".join(outcome.err.split())
    assert "Traceback" not in outcome.err


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("setup_time: 5", "setup_time: -5", "setup_time"),
        ("setup_time: 5", "setup_time: t", "setup_time"),
        ("setup_time: 5", "forbidden: [nowhere]", "'nowhere'"),
        ("setup_time: 5", "forbidden: [there, back, still]", "all are forbidden"),
        ("setup_time: 5", "setuptime: 5", "unknown key 'setuptime'"),
        ("{name: still, fix", "{name: back, fix", "there is a run 'back' already"),
        ("setup_time: 5", "setup_time: g", "no value: g"),
    ],
)
def test_a_wrong_plan_is_2(plan, old, new, message):
    text = TABLE.replace(old, new)
    if new.endswith(": g"):
        text = text.replace("g: 10", "g: null")
        message = "g"
    outcome = plan(text)

    assert (outcome.status, outcome.out) == (2, "")
    assert message in outcome.err


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("noise: {R: {y: 1e-4, z: 1e-2}, ", "noise: {"),
        ("b: 0.01,", "b: s,"),
    ],
)
def test_undecided_is_4_only_where_strict(plan, old, new):
    """Requirements that cannot be judged, for want of noise or of a value."""
    text = TABLE.replace(old, new).replace("g: 10", "g: 10, s: null")

    assert plan(text).status == 0
    assert plan(text, "--strict").status == 4


def test_nothing_asked_for_nothing_open(plan):
    text = "".join(line for line in TABLE.splitlines(keepends=True) if line[:5] not in {"noise", "requi"})
    assert plan(text, "--strict").status == 0


# -- streams, formats, files


@pytest.mark.parametrize("form", ["terminal", "json", "markdown", "latex", "html"])
def test_the_report_alone_is_on_stdout(plan, form):
    outcome = plan(TABLE, "--format", form)

    assert (outcome.status, outcome.err) == (0, "")
    assert all(name in outcome.out for name in ("there", "back", "still"))


def test_html_carries_its_figures(plan):
    out = plan(TABLE, "--format", "html").out
    assert out.lower().startswith("<!doctype html>")
    assert out.count("<svg") >= 2


def test_output_goes_to_a_file(plan, tmp_path):
    file = tmp_path / "report.md"
    outcome = plan(TABLE, "--format", "markdown", "--output", file)

    assert (outcome.status, outcome.out, outcome.err) == (0, "", "")
    assert file.read_text(encoding="utf-8").startswith("#")


def test_figures_are_drawn(plan, tmp_path):
    assert plan(TABLE, "--plot", tmp_path / "f").status == 0

    drawn = sorted(path.name for path in (tmp_path / "f").iterdir())
    stems = {name.rsplit(".", 1)[0] for name in drawn}
    assert drawn == sorted(f"{stem}.{form}" for stem in stems for form in ("png", "svg"))
    assert {stem.rsplit("-", 1)[-1] for stem in stems} >= {"map", "deviations"}


# -- JSON


PLAN = {
    "constants", "fresh", "candidates", "forbidden", "setup_time", "rank", "rank_of_all", "columns", "size",
    "exhaustive", "guarantee", "count", "sets", "recommended", "undetermined_directions", "suggestions",
    "tried", "accuracy", "no_accuracy", "require",
}  # fmt: skip
SET = {"runs", "duration", "margin", "met", "shortest", "shortest_duration"}


def test_json_keeps_its_contract(plan):
    data = json.loads(plan(TABLE, "--format", "json").out)

    assert {"schema", "obscli", "changes", "results"} <= data.keys()
    [found] = data["results"]
    assert {"model", "plan", "verification"} <= found.keys()
    own = found["plan"]
    assert own.keys() >= PLAN
    assert all({"name", "stage", "duration", "rows", "states"} <= one.keys() for one in own["candidates"])
    assert all(one.keys() >= SET for one in (*own["sets"], own["recommended"]))
    assert all(
        {"name", "required", "before", "after", "margin", "met"} <= one.keys() for one in own["require"]
    )


def test_json_says_what_is_found(result):
    found = result(TABLE)
    own = found["plan"]

    assert (own["constants"], own["fresh"]) == (["b", "m", "u"], ["x"])
    assert [one["name"] for one in own["candidates"]] == ["there", "back", "still"]
    assert own["candidates"][2]["states"] == {"b": "observable", "m": "unobservable", "u": "observable"}
    assert (own["rank"], own["rank_of_all"], own["columns"], own["size"]) == (3, 3, 3, 2)
    assert (own["exhaustive"], own["guarantee"], own["count"]) == (True, None, 3)
    assert sets(found) == {frozenset(s) for s in ({"there", "back"}, {"there", "still"}, {"back", "still"})}
    assert own["setup_time"] == 5
    assert all(one["duration"] == 50 for one in own["sets"])
    best = own["recommended"]
    assert best == own["sets"][0]
    assert best["met"] is True
    assert best["margin"] >= 1
    assert best["shortest_duration"] == pytest.approx(sum(best["shortest"]) + 10)
    assert best["shortest_duration"] <= min(one["shortest_duration"] for one in own["sets"])
    assert all(one["met"] for one in own["require"])
    assert (own["suggestions"], own["tried"]) == ([], [])
    assert found["verification"]["verdict"] == "verified"


def test_forbidden_candidates_are_not_chosen(result):
    text = TABLE.replace("setup_time: 5", "forbidden: [still]")
    assert sets(result(text)) == {frozenset({"there", "back"})}
    assert result(text)["plan"]["forbidden"] == ["still"]
    text = TABLE.replace("setup_time: 5", "forbidden: [[there, back]]")
    assert sets(result(text)) == {frozenset(s) for s in ({"there", "still"}, {"back", "still"})}


def test_what_would_help_is_suggested(result):
    """One way only: b + w*m, never b and m."""
    text = TABLE.replace(", {name: back, fix: {w: -w}}, {name: still, fix: {w: 0}}]", "]")
    own = result(text, status=1)["plan"]

    assert (own["rank"], own["columns"]) == (2, 3)
    assert own["undetermined_directions"] == [{"coefficients": {"b": "2", "m": "-1"}}]
    assert any(one["rank"] == 3 and one["words"].startswith("w ") for one in own["suggestions"])
    assert {one["words"] for one in own["suggestions"]} <= set(own["tried"])


# -- options reach the candidates


def test_runs_are_chosen_by_name(result):
    found = result(TABLE, "--run", "still", "--run", "there")
    assert [one["name"] for one in found["plan"]["candidates"]] == ["there", "still"]
    assert sets(found) == {frozenset({"there", "still"})}


def test_without_and_outputs_reach_the_candidates(result):
    own = result(TABLE, "--without", "m")["plan"]
    assert (own["constants"], own["size"], own["rank"]) == (["b", "u"], 1, 2)
    assert [one["name"] for one in own["require"]] == ["b", "u"]
    own = result(TABLE, "--outputs", "y", status=1)["plan"]
    assert (own["constants"], own["rank"]) == (["b", "m", "u"], 2)


def test_set_and_fix_reach_the_candidates(result):
    slow, fast = (
        result(TABLE, "--set", f"w={w}", "--run", "there", "--run", "back")["plan"]["accuracy"]["states"]["m"]
        for w in ("2", "4")
    )
    assert fast["after_runs"] != slow["after_runs"]
    own = result(TABLE, "--fix", "w=0", status=1)["plan"]
    assert (own["rank"], own["size"]) == (2, 1)


def test_a_rank_lower_at_the_files_values_is_not_sold_as_the_generic_one(result):
    """At w = 0 all three candidates are the same."""
    own = result(TABLE, "--set", "w=0", status=1)["plan"]
    assert (own["rank"], own["columns"]) == (2, 3)
    assert own["require"][1]["name"] == "m"
    assert not own["require"][1]["met"]


# -- models at the edge


STAGES = """\
parameters: {w: 2}
states: [x, b, m]
let: {k: w}
dynamics: {x: b + k*m}
measurements: {y: x}
interval: {stop: 20, samples: 10}
stages: {there: {}, back: {let: {k: -w}}}
"""


def test_without_plan_and_experiment_every_stage_is_a_candidate(result):
    found = result(STAGES)
    assert [one["name"] for one in found["plan"]["candidates"]] == ["there", "back"]
    assert sets(found) == {frozenset({"there", "back"})}


def test_without_candidates_the_runs_of_the_experiment_are_chosen_from(result):
    found = result(STAGES + "experiment: {runs: [there, {stage: back, repeat: 2}]}\n")
    assert [one["name"] for one in found["plan"]["candidates"]] == ["there", "back", "back #2"]
    assert sets(found) == {frozenset({"there", "back"}), frozenset({"there", "back #2"})}


def test_a_plan_without_an_experiment_takes_what_its_candidates_share(result):
    text = """\
states: [x, c, d]
let: {k: 0, on: 1}
dynamics: {x: k*d}
measurements: {y: x + on*c}
interval: {stop: 100}
plan:
  candidates: [{name: with_c, let: {k: 1}}, {name: without_c, let: {k: 1, on: 0}}]
"""
    own = result(text)["plan"]
    assert (own["constants"], own["fresh"]) == (["c", "d"], ["x"])
    assert (own["rank"], own["columns"], own["size"]) == (1, 2, 1)


@pytest.mark.parametrize("form", ["terminal", "json", "html"])
def test_where_all_states_are_shared_nothing_starts_anew(plan, form):
    text = "states: [a, b]\ndynamics: {}\nmeasurements: {y: a + t*b}\nnoise: {R: 1}\ninterval: {stop: 9}\n"
    outcome = plan(text, "--format", form)
    assert (outcome.status, outcome.err) == (0, "")


def test_where_no_state_is_shared_there_is_nothing_to_choose(plan):
    outcome = plan("states: [x, v]\nA: [[0, 1], [-1, 0]]\nH: [[1, 0]]\ninterval: {stop: 9}\n")
    assert (outcome.status, outcome.out) == (2, "")
    assert "share no state" in outcome.err


def test_nothing_seen_there_is_nothing_to_recommend(plan, result):
    text = STAGES.replace("{y: x}", "{y: 0*x + 0*m}")
    own = result(text)["plan"]
    assert (own["rank"], own["sets"], own["recommended"]) == (0, [], None)
    assert plan(text).status == 0


def test_a_candidate_that_cannot_be_integrated_leaves_accuracy_open(plan, result):
    text = """\
states: [x, b, c]
dynamics: {x: b - x/(t - 5)}
measurements: {y: x, z: c}
noise: {R: 1, P0_std: {b: 1, c: 1}}
interval: {stop: 20, samples: 10}
require: {b: 1}
experiment: {runs: [{name: before, interval: {stop: 4}}, {name: across}]}
"""
    own = result(text)["plan"]
    assert own["accuracy"] is None
    assert "across" in own["no_accuracy"]
    assert plan(text, "--strict").status == 4


def test_an_interval_that_is_none_is_2(plan):
    outcome = plan(TABLE.replace("{name: still, ", "{name: still, interval: {stop: 0}, "))
    assert (outcome.status, outcome.out) == (2, "")
    assert "stops at 0" in outcome.err
