"""``analyze --certify`` and ``--gramian lift``: what is printed, the keys in JSON, exit codes, refusals."""

import json
from fractions import Fraction
from pathlib import Path

import pytest


INS = Path(__file__).parents[2] / "models" / "ins_calibration" / "horizontal.yaml"
NOT_REDUCIBLE = "states: [a, b]\nA: [[0, cos(t^2)], [0, 0]]\nH: [[1, 0]]\n"


@pytest.fixture
def chirp(tmp_path):
    file = tmp_path / "chirp.yaml"
    file.write_text(NOT_REDUCIBLE)
    return file


def test_the_ins_stage_at_two_instants(obscli):
    arguments = ("--stage", "stage_1", "--no-critical", "--certify", "--times", "60,600", "--format", "json")
    outcome = obscli("analyze", INS, *arguments)
    assert outcome.status == 0
    result = json.loads(outcome.out)["results"][0]
    assert result["certified_reason"] == ""
    assert [(one["t"], one["rank"]) for one in result["certified"]] == [(60.0, 16), (600.0, 16)]
    for one in result["certified"]:
        assert abs(Fraction(one["minor"]["midpoint"])) > Fraction(one["minor"]["radius"])
        assert one["precision"] >= 128
        assert one["samples"] * 3 >= 16


def test_the_section_of_the_report(obscli, integrator):
    outcome = obscli("analyze", integrator, "--certify", "--times", "1,4")
    assert outcome.status == 0
    assert "Certified rank" in outcome.out
    assert "-4.000000000 ± 0" in outcome.out


def test_a_few_instants_of_the_interval_where_none_are_given(obscli, integrator):
    outcome = obscli("analyze", integrator, "--certify", "--only", "analytic", "--format", "json")
    found = json.loads(outcome.out)["results"][0]["certified"]
    assert [one["rank"] for one in found] == [2] * 5
    assert found[-1]["t"] == 20.0


def test_nothing_is_certified_unasked(obscli, integrator):
    assert "Certified rank" not in obscli("analyze", integrator).out
    result = json.loads(obscli("analyze", integrator, "--format", "json").out)["results"][0]
    assert result["certified"] is None


def test_what_is_not_reducible_is_undecided_and_says_why(obscli, chirp):
    usual = obscli("analyze", chirp, "--certify", "--only", "analytic")
    assert usual.status == 0
    assert "no certified rank: not reducible: A[a, b]" in usual.out
    assert obscli("analyze", chirp, "--only", "analytic", "--strict").status == 0
    assert obscli("analyze", chirp, "--certify", "--only", "analytic", "--strict").status == 4
    outcome = obscli("analyze", chirp, "--certify", "--only", "analytic", "--format", "json")
    result = json.loads(outcome.out)["results"][0]
    assert result["certified_reason"].startswith("not reducible")
    assert {one["rank"] for one in result["certified"]} == {None}


def test_the_gramian_alone_has_no_exact_kernel_to_rest_on(obscli, integrator):
    outcome = obscli("analyze", integrator, "--certify", "--only", "numeric")
    assert outcome.status == 2
    assert "exact kernel" in outcome.err


def test_the_gramian_through_a_stationary_system(obscli):
    arguments = ("--stage", "stage_1", "--only", "numeric", "--times", "60,600", "--gramian", "lift")
    outcome = obscli("analyze", INS, *arguments, "--format", "json")
    assert outcome.status == 0
    found = json.loads(outcome.out)["results"][0]["numeric"]
    assert found["method"] == "lift"
    assert found["rtol"] == 0
    assert [(one["rank"], one["decided"]) for one in found["points"]] == [(16, True)] * 2
    assert "no step error" in obscli("analyze", INS, *arguments).out


def test_claims_are_verified_through_a_stationary_system(obscli):
    assert obscli("verify", INS, "--stage", "stage_2", "--gramian", "lift").status == 0


def test_refusals_of_the_method(obscli, integrator, chirp):
    outcome = obscli("analyze", chirp, "--gramian", "lift")
    assert outcome.status == 2
    assert "no stationary system for --gramian lift: not reducible" in outcome.err
    outcome = obscli("analyze", integrator, "--gramian", "lift", "--rtol", "1e-9")
    assert outcome.status == 2
    assert "no step error" in outcome.err
