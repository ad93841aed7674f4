"""``obscli simulate`` with an initial error and with feedback, as a user meets them."""

import csv
import json

import pytest


CHANNEL = """\
title: A tilt behind a velocity
parameters: {g: 9.81}
states: {V: {unit: m/s}, e: {components: [tilt, bias]}, idle: {}}
dynamics: {V: e_bias - g*e_tilt}
measurements: {speed: V}
quantities: {slope: e_bias - g*e_tilt}
noise: {R: 1e-2, step: 1, P0_std: {V: 1, e: [1e-3, 1e-2], idle: 2}}
interval: {stop: 100}
"""
REDUCED = """\
title: The tilt alone
parameters: {g: 9.81}
states: {V: {unit: m/s}, e_tilt: {unit: rad}, own: {}}
dynamics: {V: -g*e_tilt}
measurements: {speed: V}
noise: {R: 1e-2, step: 1, P0_std: {V: 1, e_tilt: 1e-3, own: 1}}
"""


@pytest.fixture
def files(tmp_path, monkeypatch):
    """The models in a directory of their own, from which the commands are run."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "channel.yaml").write_text(CHANNEL)
    (tmp_path / "reduced.yaml").write_text(REDUCED)
    return tmp_path


@pytest.fixture
def simulated(obscli, files):  # noqa: ARG001 - the models have to be there
    """Run the command; return what it found of the only stage."""

    def run(*arguments):
        outcome = obscli("simulate", *arguments, "--format", "json")
        return json.loads(outcome.out)["results"][0]["simulate"]

    return run


def test_the_mean_is_beside_the_deviations(simulated):
    found = simulated("channel.yaml", "--initial", "e_tilt=pi/180/g, idle=cos(0)", "--initial", "V=(1+1)/2")
    history, initial = found["history"], found["initial"]

    assert history["mean"] == initial["mean"]
    assert set(history["mean"]) == set(history["standard_deviation"])
    assert {len(own) for own in history["mean"].values()} == {len(history["t"])}
    assert initial["error"] == pytest.approx({"e_tilt": 0.0017791327, "idle": 1, "V": 1})
    assert initial["before"]["slope"] == pytest.approx(-0.017453293)
    assert history["mean"]["idle"] == [1.0] * len(history["t"])
    assert abs(history["mean"]["slope"][-1]) < 1e-2 * abs(initial["before"]["slope"])


def test_without_an_initial_error_there_is_no_mean(simulated):
    found = simulated("channel.yaml")
    assert (found["history"]["mean"], found["initial"], found["feedback"]) == (None, None, None)


def test_the_error_is_the_expression_at_the_start(simulated):
    found = simulated("channel.yaml", "--from", 3, "--to", 9, "--initial", "V=t**2")
    assert found["initial"]["error"] == {"V": 9.0}


@pytest.mark.parametrize(
    "way",
    [
        ["--correction", "feedback"],
        ["--feedback", "e"],
        ["--feedback", "sigma<0.5"],
        ["--feedback", "sigma>2"],
    ],
)
def test_feedback_changes_nothing_of_the_filter_of_the_model_itself(simulated, way):
    arguments = ("channel.yaml", "--initial", "V=1,e_bias=0.01", "--runs", 5)
    alone, found = simulated(*arguments), simulated(*arguments, *way)

    for name, own in alone["history"]["mean"].items():
        assert found["history"]["mean"][name] == pytest.approx(own, abs=1e-10)
        assert found["monte_carlo"]["rms"][name] == pytest.approx(alone["monte_carlo"]["rms"][name], rel=1e-8)
    assert found["history"]["standard_deviation"] == alone["history"]["standard_deviation"]


def test_of_a_filter_on_another_truth_true_errors_and_the_mean_follow_the_feedback(simulated):
    arguments = ("channel.yaml", "--set", "g=9", "--filter", "reduced.yaml", "--initial", "e_tilt=0.001")
    alone, found = simulated(*arguments), simulated(*arguments, "--feedback", "e_tilt,sigma<0.9")

    assert found["feedback"] == {"states": ["e_tilt"], "below": 0.9, "above": None}
    assert found["history"]["mean"] is None
    assert found["mismatch"]["mean"] == found["initial"]["mean"]
    assert set(found["mismatch"]["mean"]) == {"V", "e_tilt", "own"}
    assert found["mismatch"]["claimed"] == alone["mismatch"]["claimed"]
    for key in ("mean", "true"):
        assert found["mismatch"][key]["e_tilt"] != pytest.approx(alone["mismatch"][key]["e_tilt"], rel=1e-3)


def test_files_figures_and_the_report_have_it(obscli, files, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    arguments = ("--initial", "V=1", "--correction", "feedback", "--history", "h.csv", "--plot", "figures")
    outcome = obscli("simulate", "channel.yaml", *arguments)
    with (files / "h.csv").open() as file:
        rows = list(csv.DictReader(file))

    assert outcome.status == 0
    assert max(map(len, outcome.out.splitlines())) <= 80
    assert "Mean response to the initial error" in outcome.out
    assert "errors are those of output correction" in " ".join(outcome.out.split())
    assert 0 < float(rows[0]["response_V"]) < 0.02
    assert list((files / "figures").glob("*-mean*.svg"))


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--initial", "e_tlt=1"], "no state 'e_tlt'; did you mean 'e_tilt'?"),
        (["--initial", "V"], "expected NAME=VALUE"),
        (["--initial", "V=1,V=2"], "V is given twice"),
        (["--initial", "V=nothing"], "unknown name 'nothing'"),
        (["--initial", "V=1/t"], "--initial V: no number at the start 0"),
        (["--correction", "both"], "expected output or feedback"),
        (["--correction", "output", "--feedback", "V"], "feeds nothing back"),
        (["--feedback", "W"], "the filter has no state 'W'"),
        (["--feedback", "sigma<-1"], "expected one sigma<C"),
        (["--feedback", "sigma>0"], "expected one sigma>C"),
        (["--initial", "e=1"], "e is a vector: give its components, e_tilt, e_bias"),
        (["--plot", "channel.yaml"], "channel.yaml is a file; name a directory for the figures"),
        (["--feedback", "sigma >x"], "expected one sigma>C"),
        (["--feedback", "sigma=1"], "no state 'sigma=1'"),
        (["--feedback", "sigma<1,sigma<2"], "expected one sigma<C"),
        (
            ["--filter", "reduced.yaml", "--feedback", "own"],
            "the true model has no state own: nothing to correct",
        ),
    ],
)
@pytest.mark.usefixtures("files")
def test_what_cannot_be_is_refused_with_its_place(obscli, arguments, said):
    outcome = obscli("simulate", "channel.yaml", *arguments)
    assert outcome.status == 2
    assert said in " ".join((outcome.out + outcome.err).split())


def test_segments_have_an_initial_error_and_runs_as_well(obscli, files):
    (files / "parts.yaml").write_text(
        CHANNEL
        + "stages: {one: {}, two: {}}\nsegments: [{stage: one, duration: 50}, {stage: two, duration: 50}]\n"
    )
    asked = ("--initial", "V=1", "--runs", 20, "--correction", "feedback", "--format", "json")
    outcome = obscli("simulate", "parts.yaml", *asked)
    assert outcome.status == 0
    one, _, parts = (stage["simulate"] for stage in json.loads(outcome.out)["results"])
    assert parts["initial"]["error"] == {"V": 1.0}
    for name, mean in one["initial"]["mean"].items():
        assert parts["initial"]["mean"][name][-1] == pytest.approx(mean[-1], rel=1e-6, abs=1e-12)
    assert parts["monte_carlo"]["inserted"]
    assert parts["feedback"] == {"states": None, "below": None, "above": None}
    refused = obscli("simulate", "parts.yaml", "--segments", "--filter", "reduced.yaml")
    assert refused.status == 2
    assert "leave out --stage, --from, --to, --filter" in " ".join(refused.err.split())


@pytest.mark.usefixtures("files")
def test_runs_with_an_error_that_is_given_are_not_judged(obscli):
    outcome = obscli("simulate", "channel.yaml", "--initial", "V=1", "--runs", 50)
    text = " ".join(outcome.out.split())
    assert "not judged: errors at the start are given (--initial)" in text
    assert "consistent" not in text


@pytest.mark.usefixtures("files")
def test_a_wrong_name_is_refused_before_the_work(obscli, monkeypatch):
    def worked(*_, **__):
        raise AssertionError

    monkeypatch.setattr("obscli.pipelines.simulate.covariance_history", worked)
    outcome = obscli("simulate", "channel.yaml", "--initial", "W=1")
    assert outcome.status == 2
    assert "no state 'W'" in outcome.err
