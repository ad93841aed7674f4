"""``obscli simulate`` as a user meets it."""

import csv
import json
from pathlib import Path

import pytest
from pyarrow.parquet import read_table

from obscli import api


CHANNEL = """\
title: A tilt behind a velocity
parameters: {g: 9.81}
states: {V: {unit: m/s}, tilt: {unit: rad}, bias: {unit: m/s^2}, idle: {}}
dynamics: {V: bias - g*tilt}
measurements: {speed: V}
quantities: {slope: bias - g*tilt}
noise: {R: 1e-2, step: 1, P0_std: {V: 1, tilt: 1e-3, bias: 1e-2, idle: 2}}
interval: {stop: 100}
"""
REDUCED = """\
title: The tilt alone
parameters: {g: 9.81}
states: {V: {unit: m/s}, tilt: {unit: rad}}
dynamics: {V: -g*tilt}
measurements: {speed: V}
noise: {R: 1e-2, step: 1, P0_std: {V: 1, tilt: 1e-3}}
"""
SILENT = """\
title: Nothing known of noise
parameters: {k}
states: [tilt, bias]
dynamics: {tilt: k*bias}
measurements: {y: tilt}
"""
TWO = """\
title: Two outputs, two rates
states: [x, v]
dynamics: {x: v}
measurements: {fast: v, slow: x}
outputs: {slow: {every: 10, during: [[20, 40], [80, 100]]}}
noise: {R: 1, step: 1, P0_std: {x: 100, v: 100}}
interval: {stop: 100}
"""


@pytest.fixture
def files(tmp_path, monkeypatch):
    """The models in a directory of their own, from which the commands are run."""
    monkeypatch.chdir(tmp_path)
    texts = {"channel": CHANNEL, "reduced": REDUCED, "silent": SILENT, "two": TWO}
    for name, text in texts.items():
        (tmp_path / f"{name}.yaml").write_text(text)
    return tmp_path


@pytest.fixture
def simulated(obscli, files):  # noqa: ARG001 - the models have to be there
    """Run the command; return its JSON, stage by stage."""

    def run(*arguments):
        return json.loads(obscli("simulate", *arguments, "--format", "json").out)["results"]

    return run


@pytest.mark.usefixtures("files")
def test_the_report_fits_80_columns_and_tells_everything(obscli, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    outcome = obscli("simulate", "channel.yaml", "--runs", 20, "--details")

    assert (outcome.status, outcome.err) == (0, "")
    assert max(map(len, outcome.out.splitlines())) <= 80
    for heading in (
        "States",
        "Quantities",
        "Observable combinations",
        "Deviations in time",
        "20 random runs",
    ):
        assert heading in outcome.out
    assert "speed     every 1" in outcome.out
    assert "consistent: errors are as large as the filter claims" in outcome.out


def test_what_is_not_observable_is_flagged_whatever_its_deviation(simulated):
    [stage] = simulated("channel.yaml")
    found = stage["simulate"]
    verdicts = {one["name"]: one["verdict"] for one in found["forms"]}
    sigma = found["history"]["standard_deviation"]

    assert verdicts == {
        "V": "observable", "tilt": "coupled", "bias": "coupled", "idle": "unobservable", "slope": "observable",
        "g*tilt - bias": "observable",
    }  # fmt: skip
    assert sigma["bias"][-1] < sigma["bias"][0]
    assert sigma["idle"] == [2.0] * len(sigma["idle"])
    assert found["time_to_observability"]["idle"]["t"] is None


def test_times_and_requirements_are_those_of_the_history(obscli, files):
    text = (files / "channel.yaml").read_text()
    (files / "asked.yaml").write_text(text + "require: {V: 0.05, tilt: 1e-6}\n")
    outcome = obscli("simulate", "asked.yaml", "--format", "json")
    found = json.loads(outcome.out)["results"][0]["simulate"]
    t, sigma = found["history"]["t"], found["history"]["standard_deviation"]
    reached = found["time_to_observability"]["V"]

    assert outcome.status == 1
    assert (reached["limit"], reached["because"]) == (0.05, "require")
    assert all((s <= 0.05) == (instant >= reached["t"]) for instant, s in zip(t, sigma["V"], strict=True))
    assert {one["name"]: one["met"] for one in found["require"]} == {"V": True, "tilt": False}
    assert found["time_to_observability"]["slope"]["because"] == "fraction"
    assert "not as well known at the end as required: tilt" in obscli("simulate", "asked.yaml").out


def test_all_that_is_lacking_is_said_at_once_and_suffices(obscli, files):
    outcome = obscli("simulate", "silent.yaml")
    said = " ".join(outcome.out.split())

    assert outcome.status == 2
    assert "--set k=…" in said
    assert "`noise: {R: {y: …}, step: …, P0_std: {tilt: …, bias: …}}`" in said
    (files / "given.yaml").write_text(
        SILENT.replace("{k}", "{k: 1}") + "noise: {R: {y: 1}, step: 1, P0_std: {tilt: 1, bias: 1}}\n"
    )
    assert obscli("simulate", "given.yaml").status == 0


def test_one_stage_simulated_is_done_and_strict_asks_for_all(obscli, files):
    (files / "stages.yaml").write_text(
        SILENT.replace("{k}", "{k: 1}")
        + "stages:\n  bare: {}\n  noisy: {noise: {R: 1, step: 1, P0_std: [1, 1]}}\n  empty: {}\n"
    )
    outcome = obscli("simulate", "stages.yaml")

    assert outcome.status == 0
    assert "the same is missing as in stages · bare" in " ".join(outcome.out.split())
    assert obscli("simulate", "stages.yaml", "--strict").status == 4
    assert obscli("simulate", "stages.yaml", "--stage", "empty").status == 2


def test_rates_and_outages_are_told(obscli, simulated):
    [stage] = simulated("two.yaml")
    fast, slow = stage["simulate"]["outputs"]

    assert (fast["samples"], fast["every"], fast["outages"]) == (101, 1.0, [])
    assert (slow["samples"], slow["every"]) == (6, 10.0)
    assert slow["outages"] == [{"start": 0.0, "stop": 20.0}, {"start": 40.0, "stop": 80.0}]
    assert stage["simulate"]["samples"] == 107
    assert "every 10; none in 0 … 20, 40 … 80" in obscli("simulate", "two.yaml").out


def test_the_histories_in_a_file_are_those_of_the_report(obscli, files, simulated):
    [stage] = simulated("channel.yaml", "--samples", 20, "--history", "h.csv")
    found = stage["simulate"]["history"]
    with (files / "h.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))

    assert list(rows[0])[:3] == ["t", "sigma_V", "sigma_tilt"]
    assert [float(row["t"]) for row in rows] == found["t"]
    for name, values in found["standard_deviation"].items():
        assert [float(row[f"sigma_{name}"]) for row in rows] == values
    assert obscli("simulate", "channel.yaml", "--samples", 20, "--history", "h.json").status == 0
    assert json.loads((files / "h.json").read_text())["results"][0]["history"] == found


def test_several_stages_stand_below_each_other_in_one_file(obscli, files):
    (files / "stages.yaml").write_text(CHANNEL + "stages: {a: {}, b: {interval: {stop: 50}}}\n")
    assert obscli("simulate", "stages.yaml", "--history", "h.csv", "--runs", 5, "--samples", 11).status == 0
    with (files / "h.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))

    assert list(rows[0])[:2] == ["stage", "t"]
    ends = {row["stage"]: float(row["t"]) for row in rows}
    assert ends == {"a": 100.0, "b": 50.0}
    assert {"rms_V", "nees", "nees_upper", "nis", "open_loop_V"} <= set(rows[0])


def test_parquet_holds_the_same(obscli, files):
    for end in ("csv", "parquet"):
        assert obscli("simulate", "channel.yaml", "--runs", 5, "--history", f"h.{end}").status == 0
    table = read_table(files / "h.parquet").to_pydict()
    with (files / "h.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))

    assert list(table) == list(rows[0])
    assert all([float(row[name]) for row in rows] == table[name] for name in table)


@pytest.mark.usefixtures("files")
def test_a_history_that_cannot_be_written_is_refused_at_once(obscli, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    for name, word in {
        "h.txt": "must end in",
        "no/h.csv": "no directory",
        "h.parquet": "obscli[parquet]",
    }.items():
        outcome = obscli("simulate", "channel.yaml", "--history", name)
        assert (outcome.status, outcome.out) == (2, "")
        assert word in outcome.err


def test_one_seed_one_answer(simulated):
    first, again = (simulated("channel.yaml", "--runs", 10, "--seed", 3)[0]["simulate"] for _ in range(2))
    other = simulated("channel.yaml", "--runs", 10, "--seed", 4)[0]["simulate"]

    assert first["monte_carlo"] == again["monte_carlo"]
    assert first["monte_carlo"]["rms"] != other["monte_carlo"]["rms"]
    assert first["history"] == other["history"]


@pytest.mark.usefixtures("files")
def test_a_filter_on_its_own_model_claims_what_it_reaches(obscli, simulated):
    [stage] = simulated("--truth", "channel.yaml", "--filter", "channel.yaml")
    found = stage["simulate"]["mismatch"]

    assert found["ignored"] == []
    assert all(abs(one["worst"] - 1) < 1e-9 for one in found["ratio"].values())
    assert found["claimed"]["V"] == pytest.approx(stage["simulate"]["history"]["standard_deviation"]["V"])
    outcome = obscli("simulate", "channel.yaml", "--filter", "channel.yaml")
    assert "the filter claims what it reaches" in outcome.out


def test_a_filter_that_leaves_out_a_state_is_optimistic(obscli, files, simulated):
    (files / "asked.yaml").write_text(CHANNEL + "require: {tilt: 1e-1, V: 1e-1}\n")
    [stage] = simulated("asked.yaml", "--filter", "reduced.yaml", "--runs", 200)
    found, runs = stage["simulate"]["mismatch"], stage["simulate"]["monte_carlo"]

    assert found["ignored"] == ["bias", "idle"]
    assert found["true"]["tilt"][-1] > 10 * found["claimed"]["tilt"][-1]
    assert runs["rms"]["tilt"][-1] == pytest.approx(found["true"]["tilt"][-1], rel=0.2)
    assert {one["name"]: one["met"] for one in found["require"]} == {"V": True, "tilt": True}
    outcome = obscli("simulate", "asked.yaml", "--filter", "reduced.yaml", "--runs", 50)
    assert "the filter is optimistic about tilt by" in outcome.out
    assert "The filter leaves out bias idle." in outcome.out
    assert "optimistic: errors are larger than the filter claims" in " ".join(outcome.out.split())


def test_requirements_are_held_against_true_errors(obscli, files):
    """The best filter meets what the reduced one only claims to meet."""
    (files / "asked.yaml").write_text(CHANNEL + "require: {tilt: 1e-3}\n")

    assert obscli("simulate", "asked.yaml").status == 0
    assert obscli("simulate", "reduced.yaml", "--to", 100).status == 0
    outcome = obscli("simulate", "asked.yaml", "--filter", "reduced.yaml")
    assert outcome.status == 1
    assert "the filter designed on reduced: not as well known" in " ".join(outcome.out.split())


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["channel.yaml", "--truth", "channel.yaml", "--filter", "reduced.yaml"], "both name the truth"),
        (["--truth", "channel.yaml"], "--truth without --filter"),
        ([], "no model"),
        (["channel.yaml", "--step", "0"], "must be positive"),
        (["channel.yaml", "--fraction", "1"], "between 0 and 1"),
        (["channel.yaml", "--stage", "none"], "no stage 'none'"),
        (["channel.yaml", "--to", "-1"], "stops at -1, not after its start"),
        (["channel.yaml", "--filter", "gone.yaml"], "gone.yaml"),
    ],
)
@pytest.mark.usefixtures("files")
def test_what_does_not_fit_is_refused(obscli, arguments, word):
    outcome = obscli("simulate", *arguments)

    assert (outcome.status, outcome.out) == (2, "")
    assert word in outcome.err


@pytest.mark.usefixtures("files")
def test_a_filter_without_noise_is_named(obscli):
    outcome = obscli("simulate", "channel.yaml", "--filter", "silent.yaml")

    assert outcome.status == 2
    assert "silent.yaml: parameter without a value: k" in " ".join(outcome.out.split())


def test_an_interrupt_keeps_what_is_done(obscli, files, monkeypatch):
    """Ctrl-C in the covariance: exit code 130, a report and a history of the instants before it."""
    truly = api.simulate
    (files / "long.yaml").write_text(
        CHANNEL.replace("dynamics: {V:", "dynamics: {bias: -sin(t/3)*bias, V:").replace(
            "stop: 100", "stop: 3000"
        )
    )

    def interrupted(*arguments, progress, **named):
        def press(step):
            progress(step)
            _, found, instant = step.partition("t = ")
            if found and float(instant.split()[0]) > 500:
                raise KeyboardInterrupt

        return truly(*arguments, progress=press, **named)

    monkeypatch.setattr(api, "simulate", interrupted)
    outcome = obscli("simulate", "long.yaml", "--history", "h.csv", "--runs", 5)
    with (files / "h.csv").open(newline="") as file:
        last = float(list(csv.DictReader(file))[-1]["t"])

    assert outcome.status == 130
    assert 0 < last < 3000
    assert f"interrupted at t = {last:.6g} of 3000" in outcome.out
    assert "random runs" not in outcome.out


def test_several_stages_come_into_one_figure(obscli, tmp_path):
    text = (
        "states: {v: {}, b: {}}\nA: [[0, 1], [0, 0]]\nH: [[1, 0]]\nquantities: {sum: v + b}\n"
        "noise: {R: [1], step: 1, P0_std: [1, 1]}\ninterval: {stop: 9}\n"
        "stages: {good: {}, poor: {noise: {R: [9]}}}\n"
    )
    (tmp_path / "m.yaml").write_text(text)
    found = obscli("simulate", tmp_path / "m.yaml", "--plot", tmp_path / "f")
    assert found.status == 0, found.err
    names = {one.stem for one in (tmp_path / "f").glob("*.svg")}
    together = {name for name in names if name.startswith("m-")}
    assert together == {"m-deviations-of-quantities", "m-deviations-of-states"}
    asked = ("--runs", 3, "--initial", "b=1", "--plot", tmp_path / "g")
    assert obscli("simulate", tmp_path / "m.yaml", *asked).status == 0
    names = {one.stem for one in (tmp_path / "g").glob("m-*.svg")}
    parts = ("deviations", "mean", "rms")
    assert names == {f"m-{part}-of-{name}" for part in parts for name in ("quantities", "states")}


def test_figures_of_every_part(obscli, files):
    outcome = obscli(
        "simulate", "reduced.yaml", "--filter", "reduced.yaml", "--to", 50, "--runs", 5, "--plot", "f"
    )
    drawn = {path.stem for path in (files / "f").glob("*.svg")}

    assert outcome.status == 0
    assert drawn == {"reduced-deviations", "reduced-mismatch", "reduced-consistency"}


@pytest.mark.usefixtures("files")
def test_every_format_has_it(obscli):
    for form in ("markdown", "latex", "html"):
        named = ("--filter", "reduced.yaml", "--to", 50, "--format", form)
        outcome = obscli("simulate", "reduced.yaml", *named)
        assert outcome.status == 0
        assert "the filter claims what it reaches" in outcome.out


def keys(value, named):
    """Yield every key of JSON values but those that are names of the file."""
    if isinstance(value, list):
        for item in value:
            yield from keys(item, named)
    if isinstance(value, dict):
        for key, below in value.items():
            if key not in named:
                yield key
            yield from keys(below, named)


def test_every_field_of_the_json_is_explained(simulated):
    page = (Path(__file__).parents[2] / "docs/simulation.md").read_text(encoding="utf-8")
    arguments = ("--runs", 2, "--initial", "V=1", "--correction", "feedback")
    [stage] = simulated("channel.yaml", "--filter", "reduced.yaml", *arguments)
    found = stage["simulate"]
    named = {name for one in found["forms"] for name in (one["name"], *one["coefficients"])}

    assert {key for key in keys(found, named) if f"`{key}`" not in page} == set()
