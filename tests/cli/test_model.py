"""``obscli model``: the library, and reading without analysing."""

import pytest

from obscli.model.library import bundled_models


def test_list_names_every_bundled_model(obscli):
    outcome = obscli("model", "list")

    assert outcome.status == 0
    assert [line.split()[0] for line in outcome.out.splitlines()] == list(bundled_models())


@pytest.mark.parametrize("name", bundled_models())
def test_show_prints_the_file(obscli, name):
    assert obscli("model", "show", name).out == bundled_models()[name].read_text(encoding="utf-8")


def test_show_of_an_unknown_model(obscli):
    outcome = obscli("model", "show", "nonesuch")

    assert outcome.status == 2
    assert "obscli model list" in outcome.err


def test_check_says_what_it_read(obscli, integrator):
    outcome = obscli("model", "check", integrator)

    assert outcome.status == 0
    assert "n = 2, m = 1" in outcome.out


def test_check_reports_every_problem(obscli, tmp_path):
    file = tmp_path / "bad.yaml"
    file.write_text("states: [a]\nA: [[b]]\nH: [[c]]\n")

    outcome = obscli("model", "check", file)

    assert outcome.status == 2
    assert "'b'" in outcome.err
    assert "'c'" in outcome.err
