"""``measures`` and ``require`` under ``expect``: data with places, in the names of each stage."""

import pytest

from obscli.model.notation import to_text
from obscli.model.reader import load_claims, read_text


LINES = """\
states: {psi: 2, b: 1}
parameters: {g: 9.8, R: 6378137}
let: {c: 2*g}
dynamics: {psi1: b}
measurements: {y: psi}
quantities: {tilt: psi1 - g*b, e: psi}
require: {psi: 1, e: 2}
stages: {one: {}, two: {fix: {g: R}}}
"""


def claims_of(lines, stage=0):
    return read_text(LINES + lines, "test.yaml").systems[stage].claims


def told(claim):
    return [
        (
            one.key, one.target, one.value and to_text(one.value), one.tolerance and to_text(one.tolerance),
            one.place.line, one.place.column, one.key_place.column,
        )
        for one in claim.measures
    ]  # fmt: skip


def test_a_value_is_of_the_system_or_of_a_target_infinite_or_with_a_tolerance():
    (claim,) = claims_of(
        "expect:\n"
        "- measures:\n"
        "    determinant: g^4\n"
        "    condition: {value: 5.8e13, tolerance: 1/100}\n"
        "    least-squares: {b: 0.58, tilt: {value: 1/c, tolerance: 1e-3}, psi1: inf}\n"
        "    anything at all: {value: inf}\n"
    )
    assert told(claim) == [
        ("determinant", None, "g**4", None, 11, 18, 5),
        ("condition", None, "58000000000000", "1/100", 12, 24, 5),
        ("least-squares", "b", "29/50", None, 13, 24, 5),
        ("least-squares", "tilt", "1/(2*g)", "1/1000", 13, 44, 5),
        ("least-squares", "psi1", None, None, 13, 73, 5),
        ("anything at all", None, None, None, 14, 30, 5),
    ]


def test_a_value_of_a_vector_is_that_of_every_component():
    (claim,) = claims_of("expect: {measures: {stochastic: {psi: 1, e: 2}}}\n")
    assert [(one.target, to_text(one.value)) for one in claim.measures] == [
        ("psi1", "1"), ("psi2", "1"), ("e1", "2"), ("e2", "2"),
    ]  # fmt: skip


def test_what_is_no_name_is_kept_as_it_stands():
    (claim,) = claims_of('expect: {measures: {deterministic: {"psi1  - g*b": 1, "-1": 2}}}\n')
    assert [one.target for one in claim.measures] == ["psi1 - g*b", "-1"]


def test_the_names_of_the_stage_count():
    lines = "expect: [{measures: {determinant: g^4}}, {stage: two, require: missed}]\n"
    assert [to_text(claims_of(lines, stage)[0].measures[0].value) for stage in (0, 1)] == ["g**4", "R**4"]
    assert [len(claims_of(lines, stage)) for stage in (0, 1)] == [1, 2]


def test_requirements_are_met_or_missed_all_or_by_name():
    everything, named, nothing = claims_of(
        "expect:\n- require: met\n- require: {psi: missed, tilt: met, e: missed}\n- rank: 2\n"
    )
    assert [(name, word, place.line, place.column) for name, (word, place) in everything.requirements.items()] == [
        ("", "met", 10, 12),
    ]  # fmt: skip
    assert {name: word for name, (word, _) in named.requirements.items()} == {
        "psi1": "missed", "psi2": "missed", "tilt": "met", "e1": "missed", "e2": "missed",
    }  # fmt: skip
    assert named.requirements["tilt"][1].column == 32
    assert (nothing.measures, nothing.requirements) == ((), {})


@pytest.mark.parametrize("lines", ["expect: [{measures: {}}]", "expect: [{require: {}}]"])
def test_nothing_may_be_expected(lines):
    (claim,) = claims_of(f"{lines}\n")
    assert (claim.measures, claim.requirements) == ((), {})


def test_of_an_experiment_and_from_a_file_of_its_own(tmp_path):
    expected = "expect: {experiment: all, require: {tilt: missed}, measures: {modal: 2}}\n"
    text = f"{LINES}experiment: {{name: all, runs: [one, two]}}\n"
    (inside,) = read_text(text + expected, "test.yaml").claims
    (tmp_path / "colleague.yaml").write_text(expected)
    (outside,) = load_claims(read_text(text, "test.yaml"), tmp_path / "colleague.yaml")[None]
    for claim in (inside, outside):
        assert [(name, word) for name, (word, _) in claim.requirements.items()] == [("tilt", "missed")]
        assert [(one.key, one.target, to_text(one.value)) for one in claim.measures] == [("modal", None, "2")]
