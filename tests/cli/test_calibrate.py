"""``obscli calibrate``: exit codes, options, formats, JSON, figures, and models at the edge."""

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
quantities: {q: b + w*m}
require: {b: 0.01, m: 0.01, u: 1}
experiment:
  name: both_ways
  description: there and back
  runs: [{name: there}, {name: back, fix: {w: -w}}]
"""
ONLY_THERE = TABLE.replace(", {name: back, fix: {w: -w}}", "")


@pytest.fixture
def calibrate(obscli, tmp_path):
    """Run ``obscli calibrate`` on a model text."""

    def run(text, *arguments):
        file = tmp_path / "table.yaml"
        file.write_text(text)
        return obscli("calibrate", file, *arguments)

    return run


@pytest.fixture
def result(calibrate):
    """Return the one result in JSON."""

    def run(text, *arguments, status=0):
        outcome = calibrate(text, "--format", "json", *arguments)
        assert (outcome.status, outcome.err) == (status, "")
        [found] = json.loads(outcome.out)["results"]
        return found

    return run


# -- exit codes


def test_all_well_is_0(calibrate):
    outcome = calibrate(TABLE, "--strict")

    assert (outcome.status, outcome.err) == (0, "")
    assert outcome.out.startswith("table · both_ways\n")


def test_a_requirement_that_is_not_met_is_1(calibrate):
    outcome = calibrate(TABLE.replace("m: 0.01, u: 1}", "m: 0.01, u: 0.01}"))

    assert (outcome.status, outcome.err) == (1, "")


def test_a_state_that_is_asked_for_and_not_determined_is_1(calibrate):
    """One run leaves b and m at their priors."""
    assert calibrate(ONLY_THERE).status == 1
    assert calibrate(TABLE, "--run", "back").status == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--run", "bakc"), "no run 'bakc'; did you mean 'back'?"),
        (("--run", ""), "no run ''"),
        (("--only", "numeric"), "is not one of analytic"),
        (("--format", "paper"), "terminal, json, markdown, latex, html"),
        (("--set", "omega=1"), "'omega' is no parameter"),
        (("--set", "w"), "NAME=VALUE"),
        (("--fix", "w=omega"), "unknown name 'omega'"),
        (("--without", "y"), "'y' is no state"),
        (("--outputs", "b"), "'b' is no output"),
        (("--samples", "0"), "greater than or equal to 1"),
        (("--rtol", "7"), "7 is no step error"),
        (("--scaling", "unit"), "automatic, scale, prior, none"),
        (("--scaling", "scale"), "`scale` of the states; missing for"),
        (("--only", "analytic", "--samples", "3"), "finds no Gramian"),
        (("--only", "analytic", "--rtol", "1e-9"), "finds no Gramian"),
        (("--only", "analytic", "--scaling", "none"), "finds no Gramian"),
        (("--stage", "one"), "No such option"),
    ],
)
def test_what_cannot_be_asked_is_2_and_prints_nothing(calibrate, arguments, message):
    outcome = calibrate(TABLE, *arguments)

    assert (outcome.status, outcome.out) == (2, "")
    assert message in " ".join(outcome.err.split())
    assert "Traceback" not in outcome.err


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (TABLE.replace("name: back", "name: there"), "there is a run 'there' already"),
        (TABLE.replace("runs:", "rums:"), "unknown key 'rums'"),
        (TABLE + "constant: [b]\n", "unknown key 'constant'"),
        (TABLE.replace("m: 0.01, u: 1}", "m: 0.01, v: 1}"), "'v'"),
        (TABLE.replace("  description", "  constant: [x]\n  description"), "'x' is not constant"),
        ("states: [x]\n", "table.yaml:1:1"),
    ],
)
def test_a_wrong_model_is_2_with_its_places(calibrate, text, message):
    outcome = calibrate(text)

    assert (outcome.status, outcome.out) == (2, "")
    assert message in outcome.err
    assert "table.yaml:" in outcome.err


def test_a_model_that_is_not_there_is_2(obscli, tmp_path):
    outcome = obscli("calibrate", tmp_path / "none.yaml")
    assert (outcome.status, outcome.out) == (2, "")
    assert "none.yaml" in outcome.err


@pytest.mark.parametrize(
    "text",
    [
        pytest.param(TABLE.replace("noise: {R: {y: 1e-4, z: 1e-2}, ", "noise: {"), id="no R"),
        pytest.param(TABLE.replace("g: 10", "g: null"), id="no value"),
        pytest.param(TABLE.replace("b: 0.01,", "b: g,").replace("g: 10", "g: 10, s: null")
                     .replace("b: g,", "b: s,"), id="no value of a requirement"),
        pytest.param(TABLE.replace("require:", "#"), id="everything decided"),
    ],
)  # fmt: skip
def test_undecided_is_4_only_where_strict(calibrate, text, request):
    decided = "everything" in request.node.name

    assert calibrate(text).status == 0
    assert calibrate(text, "--strict").status == (0 if decided else 4)


def test_what_is_asked_for_without_noise_is_4_only_where_strict(calibrate):
    text = "".join(line for line in TABLE.splitlines(keepends=True) if not line.startswith("noise"))

    assert calibrate(text).status == 0
    assert calibrate(text, "--strict").status == 4
    assert calibrate(text, "--strict", "--only", "analytic").status == 0


def test_not_met_is_1_where_strict_as_well(calibrate):

    failing = TABLE.replace("m: 0.01, u: 1}", "m: 0.01, u: 0.01}")
    assert calibrate(failing, "--strict").status == 1


# -- streams, formats, files


@pytest.mark.parametrize("form", ["terminal", "json", "markdown", "latex", "html"])
def test_the_report_alone_is_on_stdout(calibrate, form):
    outcome = calibrate(TABLE, "--format", form)

    assert (outcome.status, outcome.err) == (0, "")
    assert "both_ways" in outcome.out.replace("\\_", "_").replace("\\allowbreak", "")
    assert outcome.out.endswith("\n")


def test_progress_goes_to_stderr_and_leaves_the_report_alone(calibrate, monkeypatch):
    quiet = calibrate(TABLE)
    monkeypatch.setattr("obscli.cli.progress.PATIENCE", 0.001)
    monkeypatch.setattr("obscli.cli.progress.BEAT", 0.001)
    told = calibrate(TABLE)

    assert told.out == quiet.out
    assert all(line.startswith("obscli: ") for line in told.err.splitlines())


@pytest.mark.parametrize(
    ("form", "start"),
    [("markdown", "#"), ("latex", "\\documentclass"), ("html", "<!DOCTYPE html>"), ("json", "{")],
)
def test_formats(calibrate, form, start):
    assert calibrate(TABLE, "--format", form).out.lower().startswith(start.lower())


def test_html_carries_its_figures(calibrate):
    out = calibrate(TABLE, "--format", "html").out
    assert out.count("<svg") >= 2
    assert "<img" not in out
    assert "http://" not in out.replace("http://www.w3.org", "")


@pytest.mark.parametrize("form", ["terminal", "json", "html"])
def test_output_goes_to_a_file(calibrate, tmp_path, form):
    file = tmp_path / "report.out"
    outcome = calibrate(TABLE, "--format", form, "--output", file)

    assert (outcome.status, outcome.out, outcome.err) == (0, "", "")
    assert "both_ways" in file.read_text(encoding="utf-8")


def test_width_follows_columns(calibrate, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    assert max(map(len, calibrate(TABLE, "--details").out.splitlines())) <= 80


def test_details_say_more(calibrate):
    assert len(calibrate(TABLE, "--details").out) > len(calibrate(TABLE).out)


def test_figures_are_drawn(calibrate, tmp_path):
    outcome = calibrate(TABLE, "--plot", tmp_path / "deep" / "f")

    assert outcome.status == 0
    drawn = sorted(path.name for path in (tmp_path / "deep" / "f").iterdir())
    stems = {name.rsplit(".", 1)[0] for name in drawn}
    assert drawn == sorted(f"{stem}.{form}" for stem in stems for form in ("png", "svg"))
    assert {stem.rsplit("-", 1)[-1] for stem in stems} >= {"map", "deviations"}
    assert all(stem.startswith("table_both_ways-") for stem in stems)


def test_without_noise_only_what_is_determined_is_drawn(calibrate, tmp_path):
    text = "".join(line for line in TABLE.splitlines(keepends=True) if line[:5] not in {"noise", "requi"})
    assert calibrate(text, "--only", "analytic", "--plot", tmp_path / "f").status == 0
    assert {path.stem for path in (tmp_path / "f").iterdir()} == {"table_both_ways-map"}


def test_a_directory_that_cannot_be_made_is_refused(calibrate, tmp_path):
    (tmp_path / "taken").write_text("")
    outcome = calibrate(TABLE, "--plot", tmp_path / "taken")

    assert (outcome.status, outcome.out) == (2, "")
    assert "--plot" in outcome.err


# -- JSON


EXPERIMENT = {
    "name", "default", "constants", "fresh", "own_symbols", "runs", "matrix", "determined", "coupled",
    "undetermined", "combinations", "directions", "quantities", "certificate", "undecided", "critical",
    "critical_complete", "critical_apart", "not_searched", "after_runs", "accuracy", "no_accuracy", "require",
}  # fmt: skip


def test_json_keeps_its_contract(calibrate):
    data = json.loads(calibrate(TABLE, "--format", "json").out)

    assert data["schema"] == "obscli/1"
    assert {"schema", "obscli", "changes", "results"} <= data.keys()
    [result] = data["results"]
    assert {"model", "n", "states", "experiment", "numeric", "verification"} <= result.keys()
    assert {"name", "file", "stage"} <= result["model"].keys()
    experiment = result["experiment"]
    assert experiment.keys() >= EXPERIMENT
    assert {"rows", "columns", "rank"} <= experiment["matrix"].keys()
    for run in experiment["runs"]:
        assert {"name", "stage", "rank", "rows", "adds", "combinations", "states", "numeric",
                "verification"} <= run.keys()  # fmt: skip
    for one in experiment["require"]:
        assert {"name", "required", "before", "after", "margin", "met"} <= one.keys()
    for one in experiment["accuracy"]["states"].values():
        assert {"before", "after", "after_runs", "alone"} <= one.keys()
    assert {"t", "ends", "standard_deviation"} <= experiment["accuracy"]["history"].keys()


def test_json_says_what_is_found(result):
    found = result(TABLE)
    experiment = found["experiment"]

    assert (experiment["name"], experiment["default"]) == ("both_ways", False)
    assert (experiment["constants"], experiment["fresh"]) == (["b", "m", "u"], ["x"])
    matrix = experiment["matrix"]
    assert (matrix["rows"], matrix["columns"], matrix["rank"], matrix["rank_at_values"]) == (4, 3, 3, 3)
    assert [(run["name"], run["rank"], run["rows"], run["adds"]) for run in experiment["runs"]] == [
        ("there", 3, 2, 2),
        ("back", 3, 2, 1),
    ]
    assert experiment["determined"] == ["b", "m", "u"]
    assert (experiment["coupled"], experiment["undetermined"], experiment["directions"]) == ([], [], [])
    assert experiment["runs"][0]["states"] == {"b": "coupled", "m": "coupled", "u": "observable"}
    assert experiment["quantities"] == {"q": "observable"}
    assert [(one["condition"], one["rank"]) for one in experiment["critical"]] == [("w = 0", 2)]
    assert experiment["critical_complete"] is True
    assert experiment["after_runs"] == [2, 3]
    assert [one["name"] for one in experiment["require"]] == ["b", "m", "u"]
    assert all(one["met"] and one["margin"] > 1 for one in experiment["require"])
    assert found["verification"]["verdict"] == "verified"
    assert found["numeric"]["rank"] == 3


def test_what_is_infinite_is_no_number_of_json(calibrate):
    out = calibrate(ONLY_THERE.replace("P0_std: {x: 1, b: 1, m: 1, u: 5}", "P0_std: {x: 1}"),
                    "--format", "json").out  # fmt: skip
    data = json.loads(out, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))
    states = data["results"][0]["experiment"]["accuracy"]["states"]

    assert states["b"]["before"] == states["b"]["after"]
    assert not isinstance(states["b"]["after"], float)
    assert isinstance(states["u"]["after"], float)


def test_what_one_run_leaves_open(result):
    experiment = result(ONLY_THERE, status=1)["experiment"]

    assert experiment["determined"] == ["u"]
    assert experiment["coupled"] == ["b", "m"]
    assert experiment["directions"] == [{"coefficients": {"b": "w", "m": "-1"}}]
    assert [one["met"] for one in experiment["require"]] == [False, False, True]


# -- options reach the runs


def test_only_analytic_finds_no_gramian(result, monkeypatch):
    def forbidden(*_):
        pytest.fail("a Gramian is found")

    monkeypatch.setattr("obscli.numeric.analysis.analyze", forbidden)
    found = result(TABLE, "--only", "analytic")

    assert (found["numeric"], found["verification"]) == (None, None)
    experiment = found["experiment"]
    assert (experiment["matrix"]["rank"], experiment["accuracy"], experiment["require"]) == (3, None, [])
    assert all(run["numeric"] is run["verification"] is None for run in experiment["runs"])


def test_no_critical_searches_none(result):
    experiment = result(TABLE, "--only", "analytic", "--no-critical")["experiment"]
    assert (experiment["critical"], experiment["critical_complete"]) == ([], False)


def test_runs_are_chosen_by_name(result):
    for given in (("--run", "back", "--run", "there"), ("--run", "there", "--run", "back")):
        names = [run["name"] for run in result(TABLE, *given)["experiment"]["runs"]]
        assert names == ["there", "back"]
    experiment = result(TABLE, "--run", "back", status=1)["experiment"]
    assert [run["name"] for run in experiment["runs"]] == ["back"]
    assert experiment["combinations"][0]["coefficients"] == {"b": "1", "m": "-w"}


def test_fix_reaches_the_runs(result):
    experiment = result(TABLE, "--fix", "w=3", "--only", "analytic")["experiment"]
    rows = [run["combinations"][0]["coefficients"] for run in experiment["runs"]]
    assert rows == [{"b": "1", "m": "3"}, {"b": "1", "m": "-3"}]
    assert result(TABLE, "--fix", "w=0", status=1)["experiment"]["matrix"]["rank"] == 2


def test_set_reaches_the_runs(result):
    def after(value):
        found = result(TABLE, "--set", f"w={value}", status=int(value == "0"))["experiment"]
        return (
            found["matrix"]["rank"],
            found["matrix"]["rank_at_values"],
            found["accuracy"]["states"]["m"]["after"],
        )

    assert after("0")[:2] == (3, 2)
    assert after("2")[:2] == after("4")[:2] == (3, 3)
    assert after("4")[2] == pytest.approx(after("2")[2] / 2, rel=1e-6)


def test_without_reaches_the_runs(result):
    experiment = result(TABLE, "--without", "m")["experiment"]
    assert experiment["constants"] == ["b", "u"]
    assert experiment["runs"][1]["combinations"][0]["coefficients"] == {"b": "1"}
    assert [one["name"] for one in experiment["require"]] == ["b", "u"]


def test_outputs_reach_the_runs(result):
    experiment = result(TABLE, "--outputs", "z", status=1)["experiment"]
    assert experiment["determined"] == ["u"]
    assert experiment["undetermined"] == ["b", "m"]
    assert experiment["matrix"]["rows"] == 2


def test_changes_are_recorded(calibrate):
    given = ("--set", "g=9", "--fix", "w=3", "--outputs", "y", "--without", "u", "--only", "analytic")
    data = json.loads(calibrate(TABLE, *given, "--format", "json").out)
    assert data["changes"] == {"set": {"g": "9"}, "fix": {"w": "3"}, "outputs": ["y"], "without": ["u"]}


def test_samples_and_scaling_reach_the_gramians(result):
    text = TABLE.replace("samples: 10", "samples: 40")
    found = result(text, "--samples", "7", "--scaling", "prior", "--rtol", "1e-12")

    assert {len(run["numeric"]["points"]) for run in found["experiment"]["runs"]} == {7}
    assert found["numeric"]["scaling"] == "prior"
    assert {run["numeric"]["rtol"] for run in found["experiment"]["runs"]} == {1e-12}
    assert found["verification"]["verdict"] == "verified"


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


def test_without_an_experiment_every_stage_is_a_run(calibrate, result):
    found = result(STAGES)["experiment"]

    assert (found["default"], found["name"]) == (True, "")
    assert [run["name"] for run in found["runs"]] == ["there", "back"]
    assert (found["constants"], found["matrix"]["rank"]) == (["b", "m"], 2)
    assert "every stage counts as a run" in calibrate(STAGES).out


def test_a_model_of_one_system_is_one_run(result):
    found = result(STAGES.replace("stages:", "#"))["experiment"]
    assert [run["name"] for run in found["runs"]] == ["table"]
    assert found["matrix"]["rank"] == 1


def test_an_experiment_of_one_run(result):
    found = result(STAGES + "experiment: {runs: [back]}\n")["experiment"]
    assert [run["name"] for run in found["runs"]] == ["back"]
    assert (found["matrix"]["rows"], found["matrix"]["rank"]) == (1, 1)


@pytest.mark.parametrize("form", ["terminal", "json", "markdown", "latex", "html"])
def test_where_no_state_is_shared_there_is_nothing_to_determine(calibrate, form):
    outcome = calibrate(
        "states: [x, v]\nA: [[0, 1], [-1, 0]]\nH: [[1, 0]]\ninterval: {stop: 9}\n", "--format", form
    )
    assert (outcome.status, outcome.err) == (0, "")
    if form == "json":
        experiment = json.loads(outcome.out)["results"][0]["experiment"]
        assert (experiment["constants"], experiment["fresh"]) == ([], ["x", "v"])
        assert (experiment["matrix"]["rows"], experiment["matrix"]["columns"]) == (0, 0)


@pytest.mark.parametrize("form", ["terminal", "json", "markdown", "latex", "html"])
def test_where_all_states_are_shared_nothing_starts_anew(calibrate, form):
    text = "states: [a, b]\ndynamics: {}\nmeasurements: {y: a + t*b}\nnoise: {R: 1}\ninterval: {stop: 9}\n"
    outcome = calibrate(text, "--format", form)
    assert (outcome.status, outcome.err) == (0, "")
    if form == "json":
        experiment = json.loads(outcome.out)["results"][0]["experiment"]
        assert (experiment["constants"], experiment["fresh"]) == (["a", "b"], [])
        assert experiment["determined"] == ["a", "b"]


def test_a_run_without_measurements_of_what_is_shared(result):
    found = result(STAGES.replace("{y: x}", "{y: 0*x + 0*m}"))["experiment"]
    assert (found["matrix"]["rows"], found["matrix"]["rank"]) == (0, 0)
    assert found["undetermined"] == ["b", "m"]


POLE = """\
states: [x, b, c]
dynamics: {{x: {rate}}}
measurements: {{y: x, z: c}}
noise: {{R: 1, P0_std: {{b: 1, c: 1}}}}
interval: {{stop: 20, samples: 10}}
require: {{b: 1}}
experiment: {{runs: [{{name: before, interval: {{stop: 4}}}}, {{name: across}}]}}
"""


@pytest.mark.parametrize("rate", ["b - x/(t - 5)", "b*exp(1/(t - 5))"])
def test_a_run_that_cannot_be_integrated_has_no_accuracy_and_says_which(calibrate, result, rate):
    """A pole within the interval of one run: the exact side stands, the rest is open."""
    text = POLE.format(rate=rate)
    experiment = result(text)["experiment"]

    assert experiment["accuracy"] is None
    assert "across" in experiment["no_accuracy"]
    assert calibrate(text, "--strict").status == 4
    assert calibrate(text, "--strict", "--run", "before").status == 0


@pytest.mark.parametrize("rate", ["b/(t - 5)^2", "b/(t - 5)", "b/(t - 5)^3"])
def test_no_accuracy_is_told_across_a_pole(calibrate, result, rate):
    text = POLE.format(rate=rate)
    experiment = result(text)["experiment"]

    assert experiment["accuracy"] is None
    assert calibrate(text, "--strict").status == 4


def test_an_interval_that_is_none_leaves_the_gramian_out(calibrate, result):
    text = TABLE.replace("{name: there}", "{name: there, interval: {stop: 0}}")
    experiment = result(text)["experiment"]

    assert experiment["matrix"]["rank"] == 3
    assert experiment["accuracy"] is None
    assert "stops at 0" in experiment["no_accuracy"]
    assert calibrate(text, "--strict").status == 4


def test_a_hundred_runs_alike_take_no_longer_to_prove(result):
    """Analysed once: the rows of all of them are those of one."""
    text = TABLE.replace("{name: there}", "{name: there, repeat: 100}")
    found = result(text, "--only", "analytic", "--no-critical")["experiment"]
    assert len(found["runs"]) == 101
    assert (found["matrix"]["rows"], found["matrix"]["rank"]) == (202, 3)
    assert sum(run["adds"] for run in found["runs"]) == 3
