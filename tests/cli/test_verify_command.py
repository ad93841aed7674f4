"""``obscli verify`` as it is typed: where it finds models and claims, what it says, with which exit code."""

import json
import os
import subprocess
import sys

import pytest


TABLE = """\
title: A turntable
parameters: {g: 9.81, omega: 0.1}
states: [tilt, bias, drift, scale]
dynamics: {tilt: drift + omega*scale}
measurements: {y: g*tilt - bias}
"""
RIGHT = "claims:\n  - basis: [g*tilt - bias, drift + omega*scale]\n"
MISTYPED = "claims:\n  - rank: 2\n  - basis:\n      - g*tilt - bias\n      - drift - omega*scale\n"
OPEN = "claims:\n  - rank: 2\nexpect:\n  - measures: {stochastic: {tilt: 1/2}}\n"
BROKEN = "states: [a]\nA: [[b]]\nH: [[1]]\n"


@pytest.fixture
def typed(tmp_path):
    """Run ``obscli`` in a process of its own, in a directory of its own; return exit code, stdout, stderr.

    However slow the machine, it does not lose patience and tell its progress.
    """
    code = "import obscli.cli.progress as p; p.PATIENCE = 3600; from obscli.cli import run; run()"

    def run(*arguments):
        done = subprocess.run(
            [sys.executable, "-c", code, *map(str, arguments)],
            cwd=tmp_path, capture_output=True, check=False, timeout=60, text=True, encoding="utf-8",
            env={**os.environ, "COLUMNS": "100", "PYTHONIOENCODING": "utf-8"},
        )  # fmt: skip
        return done.returncode, done.stdout, done.stderr

    return run


@pytest.fixture
def put(tmp_path):
    """Write a file below the directory in which obscli is run."""

    def write(name, text):
        file = tmp_path / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        return file

    return write


@pytest.fixture
def here(obscli, tmp_path, monkeypatch):
    """Run ``obscli verify`` in the directory, in this process."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    return lambda *arguments: obscli("verify", *arguments)


def test_all_hold_is_0(typed, put):
    put("models/table.yaml", TABLE + RIGHT)

    status, out, err = typed("verify")

    assert (status, err) == (0, "")
    head, *lines = [line for line in out.splitlines() if line]
    assert head == "table"
    assert lines[0] == "  ✓ certificate: rank 2, saturated at order 1"
    assert lines[1].startswith("  ✓ the Gramian agrees with the analysis (Gramian 150 of 150, χ ≤ ")
    assert lines[2].startswith(
        "  ✓ these 2 combinations are a complete basis (rank 2) (line 7; Gramian 150 of 150"
    )
    assert lines[-2:] == ["Summary", "  ✓ 3 checks, all hold"]


def test_one_that_fails_is_1_and_says_what_should_stand_there(typed, put):
    """The sign of one coefficient mistyped: the row, its place, what is wrong, and both ways to mend it."""
    put("table.yaml", TABLE + MISTYPED)

    status, out, err = typed("verify")

    told = " ".join(out.split())
    assert (status, err) == (1, "")
    assert "✓ rank 2 (line 7; Gramian 150 of 150)" in told
    assert (
        "✗ fails: these 2 combinations are a complete basis (rank 2): drift - omega*scale is not observable: "
        "it changes along the unobservable direction (drift: omega, scale: -1); the Gramian denies it: "
        "χ = 0.2, where rounding accounts for " in told
    )
    assert "(table.yaml:9:9)" in told
    assert (
        "• drift - omega*scale has 1 where drift needs -1, or has -omega where scale needs omega; nearest "
        "observable combinations: -drift - omega*scale, or drift + omega*scale" in told
    )
    assert "x(t) and x(t) + (drift: omega, scale: -1) give the same outputs for ever" in told
    assert "the claim says they differ by 2*omega" in told
    assert "g*tilt - bias is not observable" not in told
    assert "✗ 4 checks: 3 hold, 1 failed, 0 undecided" in told


def test_the_advice_followed_the_claim_holds(here, put):
    put("table.yaml", TABLE + MISTYPED)
    [wrong] = [one for one in _data(here("--format", "json"))["checks"] if one["verdict"] == "fails"]
    corrected = [one["corrected"] for one in wrong["corrections"]]

    assert corrected == ["-drift - omega*scale", "drift + omega*scale"]
    for one in corrected:
        put("table.yaml", TABLE + MISTYPED.replace("drift - omega*scale", one))
        assert here().status == 0


def _data(outcome):
    """Return the JSON that a run printed."""
    assert outcome.err == ""
    return json.loads(outcome.out)


@pytest.mark.parametrize(("options", "expected"), [((), 0), (("--strict",), 4)])
def test_undecided_is_4_only_where_strict(typed, put, options, expected):
    put("table.yaml", TABLE + OPEN)

    status, out, err = typed("verify", "table.yaml", *options)

    assert (status, err) == (expected, "")
    assert "? undecided: stochastic of tilt is 0.5: the file has no `noise`" in out
    assert "? 4 checks: 3 hold, 0 failed, 1 undecided" in out


def test_failed_goes_before_undecided(here, put):
    put("table.yaml", TABLE + OPEN.replace("rank: 2", "rank: 3"))

    outcome = here("--strict")

    assert outcome.status == 1
    assert "✗ 4 checks: 2 hold, 1 failed, 1 undecided" in outcome.out


@pytest.mark.parametrize("option", [("--claim", "tilt +"), ("--claims", "none.yaml"), ("--stage", "x")])
def test_what_cannot_be_asked_is_2_and_prints_nothing(typed, put, option):
    put("table.yaml", TABLE + RIGHT)

    status, out, err = typed("verify", "table.yaml", *option)

    assert (status, out) == (2, "")
    assert err
    assert "Traceback" not in err


# -- where models are looked for


def test_models_below_models_at_any_depth_and_no_others(here, put):
    put("models/one.yaml", TABLE + RIGHT)
    put("models/deep/er/two.yml", TABLE + RIGHT)
    put("three.yaml", TABLE + MISTYPED)
    put("models/notes.txt", "no model")

    outcome = here()

    assert (outcome.status, outcome.err) == (0, "")
    assert [line for line in outcome.out.splitlines() if line in {"one", "two", "three"}] == ["two", "one"]


def test_models_of_the_folder_itself_where_there_is_no_models(here, put):
    put("one.yaml", TABLE + RIGHT)
    put("two.yml", TABLE + MISTYPED)
    put("compose.yaml", "services: {}\n")
    put("below/three.yaml", BROKEN)

    outcome = here()

    assert (outcome.status, outcome.err) == (1, "")
    assert [line for line in outcome.out.splitlines() if line in {"one", "two", "three"}] == ["one", "two"]


@pytest.mark.parametrize("files", [(), ("compose.yaml",), ("models/readme.txt",)])
def test_a_folder_without_models(here, put, files):
    for name in files:
        put(name, "services: {}\n")

    outcome = here()

    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err == "obscli: no models under models nor in the current directory; name a MODEL\n"


def test_problems_of_all_models_come_before_any_check(here, put):
    put("models/a.yaml", BROKEN)
    put("models/b.yaml", TABLE + RIGHT)
    put("models/c.yaml", BROKEN.replace("[[b]]", "[[c]]"))

    outcome = here()

    assert (outcome.status, outcome.out) == (2, "")
    places = [line for line in outcome.err.splitlines() if ".yaml:" in line]
    assert [line.split(":")[0] for line in places] == ["models/a.yaml", "models/c.yaml"]


def test_models_named_are_checked_in_the_order_given(here, put):
    for name in ("b", "a", "c"):
        put(f"{name}.yaml", TABLE + RIGHT)

    outcome = here("c.yaml", "a.yaml")

    assert [line for line in outcome.out.splitlines() if line in {"a", "b", "c"}] == ["c", "a"]


# -- claims from elsewhere


def test_claims_of_a_file_stand_in_place_of_those_of_the_model(here, put):
    put("table.yaml", TABLE + MISTYPED)
    put("colleague.yaml", RIGHT)

    outcome = here("table.yaml", "--claims", "colleague.yaml")

    assert (outcome.status, outcome.err) == (0, "")
    assert "(line 2; " in outcome.out
    assert "rank 2 (line" not in outcome.out


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("- {rank: two}\n", "claims.yaml:1:10: claims[1].rank: a whole number"),
        ("- {rnak: 2}\n", "claims.yaml:1:4: claims[1]: unknown key 'rnak'; did you mean 'rank'?"),
        (
            "- basis: [drft]\n",
            "claims.yaml:1:11: claims[1].basis[1]: unknown name 'drft'; did you mean 'drift'?",
        ),
        ("- {stage: x}\n", "claims.yaml:1:11: claims[1].stage: there is no stage 'x'"),
        ("- {states: {drift: seen}}\n", "claims.yaml:1:20: claims[1].states.drift: "),
        ("a: [\n", "claims.yaml:"),
        ("\x00", "claims.yaml:1:1: "),
    ],
)
def test_an_unreadable_claims_file_is_named_with_the_place(here, put, text, message):
    put("table.yaml", TABLE)
    put("claims.yaml", text)

    outcome = here("table.yaml", "--claims", "claims.yaml")

    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err.startswith(message)
    assert "internal error" not in outcome.err


def test_a_claims_file_that_is_not_there(here, put, tmp_path):
    put("table.yaml", TABLE)
    for name in ("none.yaml", "."):
        outcome = here("table.yaml", "--claims", tmp_path / name)

        assert (outcome.status, outcome.out) == (2, "")
        assert str(tmp_path) in outcome.err
        assert "internal error" not in outcome.err


def test_claims_are_about_one_model(here, put):
    put("a.yaml", TABLE)
    put("b.yaml", TABLE)
    put("claims.yaml", RIGHT)

    outcome = here("--claims", "claims.yaml")

    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err == "obscli: --claims is about one model; 2 are given\n"


@pytest.mark.parametrize(("rank", "status"), [(1, 0), (2, 1)])
def test_claims_of_a_file_about_an_experiment_are_not_about_the_base_model(here, put, rank, status):
    """The model has rank 2 of 4; of the three states that its one run shares, M has rank 1."""
    put("table.yaml", TABLE)
    put("claims.yaml", f"- {{experiment: both, rank: {rank}}}\n")

    outcome = here("table.yaml", "--claims", "claims.yaml")

    base, experiment = outcome.out.split("table · experiment\n")
    assert "rank 2, saturated at order 1" in base
    assert "claims.yaml" not in base
    assert "✓ certificate: M is 1 × 3 of rank 1" in experiment
    assert f"rank {rank}" in experiment.split("of all runs together")[1]
    assert outcome.status == status


def test_a_claim_about_a_run_that_is_not_there_does_not_hold(here, put):
    put("table.yaml", TABLE)
    put("claims.yaml", "- {experiment: both, runs: [nope], rank: 1}\n")

    outcome = here("table.yaml", "--claims", "claims.yaml")

    assert outcome.status != 0


EXPERIMENT = """\
interval: {stop: 10}
experiment:
  name: both_ways
  runs: [{name: there}, {name: back, fix: {omega: -omega}}]
claims:
  - {experiment: both_ways, rank: 2, determined: [drift, scale]}
  - {experiment: both_ways, runs: [back], rank: 1, observable: [drift - omega*scale]}
"""


def test_claims_about_an_experiment_are_checked_like_those_about_stages(here, put):
    put("table.yaml", TABLE + EXPERIMENT)

    outcome = here("--format", "json")

    data = _data(outcome)
    assert outcome.status == 0
    assert [result["model"]["stage"] for result in data["results"]] == [None, "both_ways"]
    own = [row for row in data["checks"] if row["stage"] == "both_ways"]
    assert {row["verdict"] for row in own} == {"holds"}
    assert [(row["claim"], row["place"]) for row in own if row["place"]] == [
        ("rank 2", "table.yaml:11:35"),
        ("drift is determined", "table.yaml:11:51"),
        ("scale is determined", "table.yaml:11:58"),
        ("rank 1 by back", "table.yaml:12:49"),
        ("drift - omega*scale is determined by back", "table.yaml:12:65"),
    ]


@pytest.mark.parametrize(
    ("old", "new", "broken"),
    [
        ("rank: 2", "rank: 1", "rank 1"),
        ("[drift, scale]", "[drift, bias]", "bias is determined"),
        ("rank: 1", "rank: 2", "rank 2 by back"),
        ("drift - omega", "drift + omega", "drift + omega*scale is determined by back"),
    ],
)
def test_a_false_claim_about_an_experiment_fails(here, put, old, new, broken):
    put("table.yaml", TABLE + EXPERIMENT.replace(old, new))

    outcome = here("--format", "json")

    assert outcome.status == 1
    assert [row["claim"] for row in _data(outcome)["checks"] if row["verdict"] == "fails"] == [broken]


def test_a_claim_about_a_state_that_starts_anew_fails_and_the_rest_is_checked(here, put):
    put("table.yaml", TABLE + EXPERIMENT.replace("[drift, scale]", "[tilt, scale]"))

    outcome = here("--format", "json")

    own = [row for row in _data(outcome)["checks"] if row["place"]]
    assert outcome.status == 1
    verdicts = {row["place"].removeprefix("table.yaml:"): row["verdict"] for row in own}
    assert verdicts == {
        "11:51": "fails", "11:35": "holds", "11:57": "holds", "12:49": "holds", "12:65": "holds",
    }  # fmt: skip


@pytest.mark.parametrize(("word", "verdict"), [("true", "fails"), ("false", "holds")])
def test_shared_states_that_the_runs_leave_open_never_die_out(here, put, word, verdict):
    put("table.yaml", TABLE + EXPERIMENT.replace("rank: 2,", f"rank: 2, detectable: {word},"))

    outcome = here("--strict", "--format", "json")

    [found] = [row for row in _data(outcome)["checks"] if "detectable" in row["claim"]]
    assert (outcome.status, found["verdict"]) == (1 if verdict == "fails" else 0, verdict)
    assert "(eigenvalue 0)" in found["reason"]


def test_one_stage_alone_leaves_the_experiment_out(here, put):
    stages = "stages: {still: {fix: {omega: 0}}, turning: {}}\n"
    put("table.yaml", TABLE + stages + EXPERIMENT.replace("rank: 2,", "rank: 3,"))

    assert here().status == 1
    assert here("--stage", "turning").status == 0


def test_claims_on_the_command_line_each_a_line_of_its_own_and_no_others(here, put):
    put("table.yaml", TABLE + MISTYPED)
    given = ["tilt", "drift + omega*scale", "2*bias - 2*g*tilt"]

    outcome = here("table.yaml", "--format", "json", *(part for text in given for part in ("--claim", text)))

    checks = _data(outcome)["checks"][2:]
    assert outcome.status == 1
    assert [(one["claim"], one["verdict"]) for one in checks] == [
        ("tilt is observable", "fails"),
        ("drift + omega*scale is observable", "holds"),
        ("2*bias - 2*g*tilt is observable", "holds"),
    ]


@pytest.mark.parametrize(
    ("claim", "message"),
    [
        ("tilt +", "--claim:1:7: the expression ends"),
        ("titl", "--claim:1:1: unknown name 'titl'; did you mean 'tilt'?"),
        ("g", "--claim:1:1: "),
        ("tilt*bias", "--claim:1:5: "),
        ("", "--claim:1:1: "),
    ],
)
def test_a_claim_that_is_no_combination(here, put, claim, message):
    put("table.yaml", TABLE)

    outcome = here("table.yaml", "--claim", claim)

    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err.startswith(message)


def test_claim_and_claims_together(here, put):
    """What is typed goes before what a file says."""
    put("table.yaml", TABLE)
    put("claims.yaml", "- {rank: 3}\n")

    outcome = here("table.yaml", "--claims", "claims.yaml", "--claim", "drift + omega*scale")

    assert outcome.status == 0
    assert "drift + omega*scale is observable" in outcome.out


# -- JSON


def test_json_has_a_row_for_each_check_with_its_evidence(here, put):
    put("table.yaml", TABLE + MISTYPED + "expect: {rank: 2, measures: {stochastic: {tilt: 5}}}\n")

    outcome = here("--format", "json")

    data = _data(outcome)
    assert outcome.status == 1
    assert (data["schema"], data["failed"], data["undecided"]) == ("obscli/1", 1, 1)
    rows = data["checks"]
    assert all({"model", "stage", "claim", "verdict", "reason", "place"} <= row.keys() for row in rows)
    assert {(row["model"], row["stage"]) for row in rows} == {("table", None)}
    assert [row["verdict"] for row in rows] == ["holds", "holds", "holds", "fails", "holds", "undecided"]
    assert [row["place"] for row in rows] == [
        None, None, "table.yaml:7:11", "table.yaml:9:9", "table.yaml:11:16", "table.yaml:11:49",
    ]  # fmt: skip
    wrong = rows[3]
    assert {"of", "corrected"} <= wrong["corrections"][0].keys()
    assert wrong["counterexample"]["direction"] == {"drift": "omega", "scale": "-1"}
    assert [one["holds"] for one in wrong["basis"]["combinations"]] == [True, False]
    [result] = data["results"]
    assert (result["n"], result["m"], result["states"]) == (4, 1, ["tilt", "bias", "drift", "scale"])
    counts = {key: result["verification"][key] for key in ("holds", "fails", "undecided")}
    assert counts == {"holds": 4, "fails": 1, "undecided": 1}


def test_json_counts_are_those_of_the_exit_code(here, put):
    for claims, status in ((RIGHT, 0), (MISTYPED, 1), (OPEN, 4), ("", 0)):
        put("table.yaml", TABLE + claims)
        outcome = here("--format", "json", "--strict")
        data = _data(outcome)
        assert outcome.status == status
        assert status == (1 if data["failed"] else 4 if data["undecided"] else 0)
        assert data["failed"] == sum(row["verdict"] == "fails" for row in data["checks"])


def test_json_of_many_models_names_each(here, put):
    put("models/a.yaml", TABLE + RIGHT)
    put("models/b.yaml", TABLE + MISTYPED + "stages: {one: {}, two: {parameters: {omega: 0.2}}}\n")

    data = _data(here("--format", "json"))

    assert list(dict.fromkeys((row["model"], row["stage"]) for row in data["checks"])) == [
        ("a", None),
        ("b", "one"),
        ("b", "two"),
    ]
    assert data["failed"] == 2
