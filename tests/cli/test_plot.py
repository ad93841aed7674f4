"""``--plot DIR`` through the command line: which files, black and white, always the same, or a refusal."""

import re

import pytest


CLAIMS = (
    "claims:\n  - {stage: turning, basis: [g*tilt - bias, drift]}\n  - {stage: turning, basis: [drift]}\n"
)
SHORT = ("--samples", 5)


def names(directory):
    return sorted(path.name for path in directory.iterdir())


def both(*stems):
    return sorted(f"{stem}.{form}" for stem in stems for form in ("svg", "png"))


def test_files_of_analyze_one_set_a_stage(obscli, stages, tmp_path):
    assert obscli("analyze", stages, *SHORT, "--plot", tmp_path / "f").status == 0

    found = names(tmp_path / "f")
    for stage in ("still", "turning"):
        assert set(both(f"stages_{stage}-chi", f"stages_{stage}-singular-values")) <= set(found)
    assert all(name.startswith(("stages-", "stages_still-", "stages_turning-")) for name in found)
    assert len([name for name in found if name.endswith(".svg")]) * 2 == len(found)


def test_files_of_verify_one_for_each_claimed_basis(obscli, stages, tmp_path):
    stages.write_text(stages.read_text() + CLAIMS)

    assert obscli("verify", stages, "--stage", "turning", *SHORT, "--plot", tmp_path / "f").status == 1
    assert names(tmp_path / "f") == both(
        "stages_turning-chi", "stages_turning-claim-1-chi", "stages_turning-claim-2-chi"
    )


def test_no_kernel_no_chi(obscli, integrator, tmp_path):
    """Where everything is observable there is nothing for a combination to leak into."""
    assert obscli("analyze", integrator, *SHORT, "--plot", tmp_path / "f").status == 0
    assert "integrator-singular-values.svg" in names(tmp_path / "f")
    assert "integrator-chi.svg" not in names(tmp_path / "f")


def test_nothing_is_drawn_in_colour(obscli, stages, tmp_path):
    assert obscli("analyze", stages, *SHORT, "--only", "numeric", "--plot", tmp_path / "f").status == 0

    for file in (tmp_path / "f").glob("*.svg"):
        svg = file.read_text(encoding="utf-8")
        found = re.findall(r"(?:fill|stroke|color): *(#?[\w]+)", svg)
        assert {"#000000", "#ffffff"} <= set(found)
        for colour in set(found) - {"none"}:
            red, green, blue = re.fullmatch(r"#(..)(..)(..)", colour).groups()
            assert red == green == blue


def test_the_chi_figure_says_what_its_curves_are(obscli, stages, tmp_path):
    obscli("verify", stages, "--stage", "turning", *SHORT, "--plot", tmp_path / "f")

    svg = (tmp_path / "f" / "stages_turning-chi.svg").read_text(encoding="utf-8")
    for text in ("stages · turning: the analysis", "5 of 5 instants agree", "what rounding may account for"):
        assert f"<!-- {text} -->" in svg


def test_drawn_twice_is_drawn_the_same(obscli, stages, tmp_path):
    for directory in ("1", "2"):
        given = ("--stage", "turning", *SHORT, "--plot", tmp_path / directory)
        assert obscli("verify", stages, *given).status == 0

    assert names(tmp_path / "1") == names(tmp_path / "2")
    for name in names(tmp_path / "1"):
        first, second = ((tmp_path / directory / name).read_bytes() for directory in ("1", "2"))
        mark = re.compile(rb"(?<=[\"#])[mp][0-9a-f]{10}(?=[\")])")
        assert mark.sub(b"", first) == mark.sub(b"", second)


def test_figures_of_before_are_replaced_and_other_files_left(obscli, stages, tmp_path):
    directory = tmp_path / "f"
    directory.mkdir()
    (directory / "notes.txt").write_text("mine")
    (directory / "stages_turning-chi.svg").write_text("old")

    assert obscli("verify", stages, "--stage", "turning", *SHORT, "--plot", directory).status == 0
    assert (directory / "notes.txt").read_text() == "mine"
    assert "<svg" in (directory / "stages_turning-chi.svg").read_text(encoding="utf-8")


@pytest.mark.parametrize("command", ["analyze", "verify"])
@pytest.mark.parametrize("below", ["", "figures", "figures/new"])
def test_a_directory_that_cannot_be_made_is_refused_before_the_work(obscli, stages, command, below):
    where = stages / below if below else stages

    outcome = obscli(command, stages, "--stage", "turning", *SHORT, "--plot", where)

    assert (outcome.status, outcome.out) == (2, "")
    assert f"Invalid value for '--plot': {stages} is a file; name a directory for the figures" in outcome.err


def test_a_figure_in_the_way_of_a_directory_is_refused(obscli, stages, tmp_path):
    (tmp_path / "f" / "stages_turning-chi.svg").mkdir(parents=True)

    outcome = obscli("verify", stages, "--stage", "turning", *SHORT, "--plot", tmp_path / "f")

    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err == f"obscli: --plot {tmp_path / 'f'}: cannot be written: Is a directory\n"


def test_the_report_is_the_same_with_figures_and_without(obscli, stages, tmp_path):
    given = ("verify", stages, "--stage", "turning", *SHORT)

    assert obscli(*given, "--plot", tmp_path / "f").out == obscli(*given).out


def test_without_a_gramian_there_are_no_figures(obscli, stages, tmp_path):
    stages.write_text(stages.read_text().replace("g: 9.81", "g: {}"))

    assert obscli("verify", stages, *SHORT, "--plot", tmp_path / "f").status == 0
    assert names(tmp_path / "f") == []


def test_models_of_the_same_name_have_figures_of_their_own(obscli, stages, tmp_path):
    other = tmp_path / "other" / stages.name
    other.parent.mkdir()
    other.write_text(stages.read_text())

    assert obscli("verify", stages, other, "--stage", "turning", *SHORT, "--plot", tmp_path / "f").status == 0
    assert len(names(tmp_path / "f")) == 4
