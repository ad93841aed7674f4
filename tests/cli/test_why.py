"""``obscli why`` as a user meets it."""

import json
from pathlib import Path

import pytest

from obscli.api import why as run
from obscli.model.reader import read_text
from obscli.render.format import Surface
from obscli.render.terminal import render


INS = Path(__file__).parents[2] / "models/ins_calibration/horizontal.yaml"

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
    assert "Its hidden error stays as it is (eigenvalue 0)." in outcome.out
    assert "It becomes observable (rank 2 now):" in outcome.out
    assert "- measured as well: drift itself (rank 3), scale (rank 3)" in outcome.out
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
    arguments = ("scale", "--stage", "turning", "--fix", "omega=0", "--only", "analytic")
    [given] = why(obscli, "fixed.yaml", *arguments)
    assert "omega free" in {one["change"] for one in given["why"]["conditions"] if one["kind"] == "fix"}


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
    assert told["floor"] == "P0"
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


def test_a_state_of_the_ins_fits_one_screen_and_names_its_partner(obscli, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    outcome = obscli("why", INS, "b_g3", "--stage", "stage_1")
    lines = outcome.out.splitlines()
    assert len(lines) <= 40
    assert max(map(len, lines)) <= 80
    assert "- b_g3 + omega*M_g31 (y1, order 5)" in lines[4]
    assert "- measured as well: b_g3 itself (rank 17), M_g31 (rank 17)" in outcome.out


def test_long_formulas_are_named_by_their_states_and_shown_in_full_on_demand(obscli, put):
    names = ", ".join(f"a_state_with_a_long_name_{k}" for k in range(9))
    put("long.yaml", f"states: [{names}]\nA: zeros(9, 9)\nH: [[{', '.join('123456789')}]]\n")
    told = obscli("why", "long.yaml", "a_state_with_a_long_name_1").out
    assert "- one with a_state_with_a_long_name_0, a_state_with_a_long_name_1," in told
    assert "a_state_with_a_long_name_7 and 1 more" in told
    full = obscli("why", "long.yaml", "a_state_with_a_long_name_1", "--details").out
    assert "+ 9*a_state_with_a_long_name_8" in full


def test_a_quantity_means_in_another_stage_what_it_means_there(obscli, put):
    """q is a + s b with s of the stage: the stage that measures a + b shows its own q, not that of the first."""
    put(
        "two.yaml",
        "states: [a, b]\nlet: {s: 2}\nA: zeros(2, 2)\nH: [[1, 1]]\nquantities: {q: a + s*b}\n"
        "stages: {first: {}, second: {let: {s: 1}}}\n",
    )
    first, second = why(obscli, "two.yaml", "q")
    assert (first["why"]["verdict"], second["why"]["verdict"]) == ("coupled", "observable")
    found = [one for one in first["why"]["conditions"] if one["kind"] == "stage"]
    assert found == [
        {"change": "second", "kind": "stage", "becomes": "observable", "rank": 1, "proved": True}
    ]


def test_a_fix_that_cannot_be_undone_is_not_said_to_be_of_no_use(obscli, put):
    put(
        "held.yaml",
        "states: [x, z]\nfunctions: [f]\nA: [[0, f], [0, 0]]\nH: [[1, 0]]\nstages: {still: {fix: {f: 0}}}\n",
    )
    [told] = why(obscli, "held.yaml", "z", "--stage", "still")
    assert ("f free", "observable") in {(c["change"], c["becomes"]) for c in told["why"]["conditions"]}
    found = run(read_text(Path("held.yaml").read_text(), "gone.yaml"), "z")
    assert ("f free", "undecided") in {(c.change, c.becomes) for c in found.results[-1].finding.trials}
    assert "Not decided: f free." in obscli_text(found)


def obscli_text(report):
    return render(report, Surface(width=80, colour=False))


def test_what_the_file_s_values_cost_is_told_apart_from_the_generic(obscli, put):
    put("equal.yaml", "parameters: {a: 1, b: 1}\nstates: [x, z]\nA: [[a, 0], [0, b]]\nH: [[1, 1]]\n")
    [told] = why(obscli, "equal.yaml", "x")
    assert (told["why"]["verdict"], told["why"]["at_values"]["verdict"]) == ("observable", "coupled")
    assert told["why"]["at_values"]["because"] == ["b = a"]
    [apart] = why(obscli, "equal.yaml", "x", "--set", "b=2")
    assert apart["why"]["at_values"] is None
    text = obscli("why", "equal.yaml", "x").out
    assert "✓ for generic values observable" in text
    assert "✗ at the file's values (rank 1 because b = a) coupled" in text


def test_every_entry_has_the_same_keys(obscli, put):
    put("open.yaml", "parameters: {a: 1}\nstates: [x]\nA: [[sqrt(a - a)/(a - a)]]\nH: [[1]]\n")
    entries = [
        *why(obscli, "table.yaml", "drift"),
        *why(obscli, "table.yaml", "rate", "--only", "analytic"),
        *why(obscli, "open.yaml", "x"),
    ]
    keys = {frozenset(entry["why"]) for entry in entries}
    assert len(keys) == 1
    assert {
        "target", "verdict", "group", "directions", "seen_by", "correction", "conditions", "deviation",
        "partners", "floor",
    } <= next(iter(keys))  # fmt: skip


def test_undecided_is_four_with_strict_and_a_stage_that_is_not_there_two(obscli, put):
    put("open.yaml", "parameters: {a: 1}\nstates: [x]\nA: [[sqrt(a - a)/(a - a)]]\nH: [[1]]\n")
    assert obscli("why", "open.yaml", "x").status == 0
    assert obscli("why", "open.yaml", "x", "--strict").status == 4
    outcome = obscli("why", "table.yaml", "drift", "--stage", "turnin")
    assert outcome.status == 2
    assert "did you mean 'turning'?" in outcome.err
    wrong = obscli("why", "table.yaml", "drift", "--stage", "turning", "--from", "7", "--to", "3")
    assert wrong.status == 2
    assert "stops at 3, not after its start 7" in wrong.err
