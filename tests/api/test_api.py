"""The public interface, as a notebook uses it."""

import pytest

import obscli
from obscli.core.check import CheckResult


MODEL = """\
title: Pair
parameters: {g: 9.81}
states: [tilt, bias]
A: [[0, 0], [0, 0]]
H: [[g, -1]]
claims: [{rank: 1}]
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "pair.yaml"
    path.write_text(MODEL)
    return path


def test_analyze_a_file(file):
    [result] = obscli.analyze(file).results

    assert result.finding.rank == 1
    assert result.title == "pair"


def test_analyze_a_model_read_before(file):
    model = obscli.load(file, settings={"g": "2"})

    assert obscli.analyze(model).results[0].model is model


def test_changes_need_the_file(file):
    with pytest.raises(TypeError, match="give the path"):
        obscli.analyze(obscli.load(file), changes=obscli.Changes(fix={"g": "1"}))


def test_fix_says_what_it_changes(file):
    [result] = obscli.analyze(file, changes=obscli.Changes(fix={"g": "0"})).results

    [neglect] = result.finding.neglect
    assert (neglect.substitution, neglect.rank_before, neglect.rank_after) == ("g = 0", 1, 1)
    assert neglect.lost == ()
    assert [set(one) for one in neglect.gained] == [{"bias"}]


def test_reports_show_themselves_in_a_notebook(file):
    for report in (obscli.analyze(file), obscli.verify(file)):
        assert report._repr_markdown_().startswith("#")
        assert report._repr_latex_().startswith("\\documentclass")


def test_verify_counts(file):
    report = obscli.verify(file, claims=["tilt"])

    assert (report.failed, report.undecided) == (1, 0)


def test_a_bad_model_raises_with_every_problem(tmp_path):
    path = tmp_path / "bad.yaml"
    path.write_text("states: [a]\nA: [[b]]\nH: [[c]]\n")

    with pytest.raises(obscli.ModelError) as caught:
        obscli.load(path)

    assert len(caught.value.problems) == 2


def test_every_public_name_is_there():
    assert all(getattr(obscli, name) for name in obscli.__all__)
    with pytest.raises(AttributeError, match="nonesuch"):
        _ = obscli.nonesuch


def test_a_check_is_no_truth_value():
    with pytest.raises(TypeError, match="verdict"):
        bool(CheckResult("claim", "holds", ""))
