"""Every format, by law: registered once, tells everything, and lets nothing of a file out of its text."""

import json
import re

import pytest

import obscli
from obscli.core.visible import HIDDEN, visible
from obscli.render.format import Surface
from obscli.render.formats import FORMATS, format_named
from obscli.render.json_text import JSON
from obscli.render.latex import LATEX
from obscli.render.markdown import MARKDOWN


every_format = pytest.mark.parametrize("form", FORMATS, ids=lambda form: form.name)


def test_names_are_unique():
    assert len({form.name for form in FORMATS}) == len(FORMATS)
    assert [format_named(form.name) for form in FORMATS] == list(FORMATS)


@every_format
def test_no_control_character_gets_out(form, hostile):
    text = form.render(hostile, Surface(details=True))

    import unicodedata

    assert {c for c in text if unicodedata.category(c) in HIDDEN} <= {"\n"}


def test_names_of_any_script_get_through():
    assert visible("φ_状態") == "φ_状態"


@every_format
def test_details_only_add(form, report):
    brief = form.render(report, Surface())
    full = form.render(report, Surface(details=True))

    brief = brief.replace("<details>", "<details open>")  # a page has them folded away
    assert set(brief.splitlines()) <= set(full.splitlines())


def test_markdown_leaves_no_markup_of_a_file(hostile):
    text = MARKDOWN.render(hostile, Surface(details=True))
    outside_code = re.sub(r"(`+)(?!`).*?(?<!`)\1(?!`)", "", re.sub(r"\\[`$*_\[\]|~\\]", "", text))

    assert "<b>" not in outside_code
    assert "[bold]" not in outside_code
    for row in (line for line in text.splitlines() if line.startswith("|")):
        cells = re.sub(r"\\\|", "", row).count("|")
        assert cells in (4, 5, 6)


def test_latex_has_one_end_and_balanced_braces(hostile):
    text = LATEX.render(hostile, Surface(details=True))

    assert text.count(r"\end{document}") == 1
    assert text.rstrip().endswith(r"\end{document}")
    bare = re.sub(r"\\.", "", text)
    assert bare.count("{") == bare.count("}")
    assert all(line.count("%") == 0 for line in bare.splitlines() if not line.startswith("%"))


def test_latex_sets_cyrillic_in_its_encoding_and_asks_for_it_only_then(tmp_path):
    texts = []
    for name in ("latitude", "широта"):
        file = tmp_path / f"{len(texts)}.yaml"
        file.write_text(
            f"states: [x]\nparameters: {{{name}: 1}}\nA: [[{name}]]\nH: [[1]]\n", encoding="utf-8"
        )
        texts.append(LATEX.render(obscli.analyze(file), Surface()))

    assert r"\usepackage[T1]{fontenc}" in texts[0]
    assert r"\usepackage[T1,T2A]{fontenc}" in texts[1]


def test_json_reads_back_as_the_data(hostile):
    assert json.loads(JSON.render(hostile, Surface())) == hostile.data()


def test_colour_adds_only_escape_codes(report):
    plain = format_named("terminal").render(report, Surface(width=80))
    coloured = format_named("terminal").render(report, Surface(width=80, colour=True))

    stripped = re.sub(r"\x1b\[[0-9;]*m", "", coloured)
    assert [line.rstrip() for line in stripped.splitlines()] == plain.splitlines()


@pytest.mark.parametrize("width", [40, 60, 80, 120])
def test_the_terminal_report_fits(report, hostile, width):
    for one in (report, hostile):
        text = format_named("terminal").render(one, Surface(width=width, details=True))
        assert max(len(line) for line in text.splitlines()) <= width
