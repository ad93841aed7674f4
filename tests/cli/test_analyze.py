"""``obscli analyze``: options, formats, files."""

import json

import pytest


KEYS = {
    "rank", "order", "at_values", "frozen_rank", "combinations", "unobservable", "states", "groups",
    "quantities", "certificate", "critical", "critical_complete",
}  # fmt: skip


def analysed(obscli, *arguments):
    outcome = obscli("analyze", *arguments, "--format", "json")
    assert (outcome.status, outcome.err) == (0, "")
    return json.loads(outcome.out)


def test_json_keeps_its_contract(obscli, stages):
    data = analysed(obscli, stages)

    assert data["schema"] == "obscli/1"
    assert {"schema", "obscli", "results"} <= data.keys()
    assert [result["model"]["stage"] for result in data["results"]][-2:] == ["still", "turning"]
    for result in data["results"]:
        assert {"model", "n", "m", "states", "analytic"} <= result.keys()
        assert {"name", "file", "stage"} <= result["model"].keys()
        analytic = result["analytic"]
        assert analytic.keys() >= KEYS
        assert {"rank", "because"} <= analytic["at_values"].keys()
        for one in analytic["combinations"]:
            assert {"expression", "latex", "coefficients", "constant", "first_from"} <= one.keys()
            assert {"output", "order"} == one["first_from"].keys()
        assert all("coefficients" in one for one in analytic["unobservable"])
        assert all({"condition", "rank", "lost"} <= one.keys() for one in analytic["critical"])


def test_what_is_found_of_two_stages(obscli, stages):
    still, turning = (
        result["analytic"] for result in analysed(obscli, stages)["results"] if result["model"]["stage"]
    )

    assert (still["rank"], turning["rank"]) == (1, 2)
    assert still["states"] == {"tilt": "coupled", "bias": "coupled", "drift": "unobservable"}
    assert turning["states"]["drift"] == "observable"
    assert turning["quantities"] == {"sum": "coupled"}


def test_terminal_report_ends_with_the_stages_compared(obscli, stages):
    outcome = obscli("analyze", stages)

    assert outcome.status == 0
    assert "states × stages" in outcome.out
    assert "● observable, ◐ coupled, · unobservable" in outcome.out


def test_one_stage_only(obscli, stages):
    data = analysed(obscli, stages, "--stage", "still")

    assert [result["model"]["stage"] for result in data["results"]] == ["still"]


def test_unknown_stage_is_named_with_the_nearest(obscli, stages):
    outcome = obscli("analyze", stages, "--stage", "stil")

    assert (outcome.status, outcome.out) == (2, "")
    assert "did you mean 'still'?" in outcome.err


def test_fix_says_what_it_changes(obscli, stages):
    outcome = obscli("analyze", stages, "--stage", "turning", "--fix", "w=0")

    assert outcome.status == 0
    assert "What w = 0 changes" in outcome.out
    assert "The rank goes from 2 to 1." in outcome.out


def test_a_fix_that_only_puts_a_number_in_changes_nothing(obscli, stages):
    outcome = obscli("analyze", stages, "--stage", "turning", "--fix", "g=9.81")

    assert "Nothing: rank 2 and the same observable combinations." in outcome.out


def test_claims_of_the_file_do_not_hinder_a_fix(obscli, tmp_path):
    file = tmp_path / "model.yaml"
    file.write_text(
        "states: [a, b]\nparameters: {g: 1}\nA: [[0, g], [0, 0]]\nH: [[1, 0]]\nclaims: {observable: [b/g]}\n"
    )

    outcome = obscli("analyze", file, "--fix", "g=0")

    assert (outcome.status, outcome.err) == (0, "")
    assert "The rank goes from 2 to 1." in outcome.out


@pytest.mark.parametrize(
    ("option", "given", "message", "hint"),
    [
        ("--outputs", "wheel", "'wheel' is no output", "there are: y"),
        ("--set", "zzz=1", "'zzz' is no parameter", "there are: g, w"),
        ("--without", "tilt,bias,drift", "no state is left", ""),
    ],
)
def test_options_that_do_not_fit_say_what_there_is(obscli, stages, option, given, message, hint):
    outcome = obscli("analyze", stages, option, given)

    assert (outcome.status, outcome.out) == (2, "")
    assert message in outcome.err
    assert hint in outcome.err


def test_a_basis_file_is_a_list(obscli, stages, tmp_path):
    rows = tmp_path / "rows.yaml"
    rows.write_text("tilt + bias\ndrift\n")

    outcome = obscli("analyze", stages, "--basis", rows)

    assert outcome.status == 2
    assert "each behind a dash" in outcome.err


def test_set_changes_the_rank_at_the_values_only(obscli, stages):
    [result] = analysed(obscli, stages, "--stage", "turning", "--set", "w=0")["results"]

    assert result["analytic"]["rank"] == 2
    assert result["analytic"]["at_values"]["rank"] == 1


def test_without_and_outputs(obscli, stages):
    [result] = analysed(obscli, stages, "--stage", "turning", "--without", "bias", "--outputs", "y")[
        "results"
    ]

    assert result["states"] == ["tilt", "drift"]


@pytest.mark.parametrize("basis", ["echelon", "sparse"])
def test_basis_and_pivot_order(obscli, stages, basis):
    [result] = analysed(obscli, stages, "--stage", "still", "--basis", basis, "--pivot-order", "bias")[
        "results"
    ]

    assert result["analytic"]["rank"] == 1


def test_unknown_state_in_pivot_order(obscli, stages):
    outcome = obscli("analyze", stages, "--pivot-order", "bais")

    assert outcome.status == 2
    assert "did you mean 'bias'?" in outcome.err


def test_no_critical_leaves_the_section_out(obscli, stages):
    assert "Where the rank drops" not in obscli("analyze", stages, "--no-critical").out


def test_details_show_the_certificate(obscli, stages):
    assert "Certificate" not in obscli("analyze", stages).out
    assert "Certificate of the generic rank" in obscli("analyze", stages, "--details").out


@pytest.mark.parametrize("only", ["analytic", "numeric", "verify"])
def test_one_part_alone(obscli, stages, only):
    data = analysed(obscli, stages, "--only", only)

    found = {key for key in ("analytic", "numeric", "verification") if data["results"][0][key] is not None}
    wanted = {
        "analytic": {"analytic"},
        "numeric": {"numeric"},
        "verify": {"analytic", "numeric", "verification"},
    }
    assert found == wanted[only]


def test_only_what_there_is(obscli, stages):
    outcome = obscli("analyze", stages, "--only", "everything")

    assert outcome.status == 2
    assert "analytic, numeric, verify" in outcome.err


@pytest.mark.parametrize("given", ["w", "=1", "w="])
def test_a_pair_needs_both_sides(obscli, stages, given):
    outcome = obscli("analyze", stages, "--set", given)

    assert outcome.status == 2
    assert "NAME=VALUE" in outcome.err


@pytest.mark.parametrize("form", ["terminal", "json", "markdown", "latex"])
def test_output_goes_to_a_file(obscli, integrator, tmp_path, form):
    file = tmp_path / "report.out"

    outcome = obscli("analyze", integrator, "--format", form, "--output", file)

    assert (outcome.status, outcome.out, outcome.err) == (0, "", "")
    assert "integrator" in file.read_text(encoding="utf-8")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["integrator.yaml", "report.out"]


def test_output_into_a_missing_directory(obscli, integrator, tmp_path):
    outcome = obscli("analyze", integrator, "--output", tmp_path / "none" / "report.txt")

    assert outcome.status == 2
    assert "there is no directory" in outcome.err


def test_a_missing_model_is_named(obscli, tmp_path):
    outcome = obscli("analyze", tmp_path / "none.yaml")

    assert (outcome.status, outcome.out) == (2, "")
    assert "none.yaml" in outcome.err


def test_width_follows_columns(obscli, stages, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")

    assert max(len(line) for line in obscli("analyze", stages, "--details").out.splitlines()) <= 80


def test_a_window_verdict_tells_its_sample_motion(obscli, tmp_path):
    file = tmp_path / "open.yaml"
    file.write_text(
        "states: [y, h]\nfunctions: [f]\ndynamics: {y: -y, h: -(1 + f^2)*h}\nmeasurements: {z: y}\n"
        "interval: {stop: 5}\n"
    )
    found = json.loads(obscli("analyze", file, "--only", "structure", "--format", "json").out)
    structure = found["results"][0]["structure"]
    assert structure["scope"] == "this window, 0 to 5, with a sample motion for f"
    assert structure["verdict"] == "detectable"
    assert [(one["kind"], one["states"]) for one in structure["modes"]] == [("decaying", ["h"])]
