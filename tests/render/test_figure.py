"""Figures: one SVG and one PNG each, told apart without colour, what they show taken from the report."""

import re
import warnings
from dataclasses import replace

import pytest

from obscli.core.figure import Curve, Figure, Panel
from obscli.render.figure import FORMATS, STYLES, file_name, save


PNG = b"\x89PNG\r\n\x1a\n"
#: what an SVG may call a colour beside digits
NAMED = re.compile(
    r"(?:fill|stroke|color)\s*[:=]\s*[\"']?\s*([a-z]+|#[0-9a-f]+|rgba?\([^)]*\)|url\([^)]*\))", re.IGNORECASE
)


def colours(svg):
    """Return every colour of a drawing as red, green, blue."""
    found = set()
    for text in NAMED.findall(svg):
        if text in {"none", "currentColor"} or text.startswith("url"):
            continue
        assert re.fullmatch(r"#[0-9a-f]{6}", text), text
        found.add(tuple(int(text[k : k + 2], 16) for k in (1, 3, 5)))
    return found


def written(svg):
    """Return the texts of a drawing: matplotlib draws them as shapes and notes each in a comment."""
    return [text.strip() for text in re.findall(r"<!--(.*?)-->", svg, re.DOTALL)]


def drawn(figure, directory):
    """Return the SVG of a figure."""
    return next(file for file in save(figure, directory) if file.suffix == ".svg").read_text(encoding="utf-8")


def curve(emphasis="main", label="", y=(1.0, 2.0, 3.0), **more):
    return Curve(label, (0.0, 1.0, 2.0), y, emphasis, **more)


def figure(*curves, name="sample", logarithmic=False, **more):
    return replace(Figure(name, "A sample", "t", (Panel("", "y", curves, logarithmic),)), **more)


EVERY = [curve(emphasis, emphasis, (1.0, 2.0 + k, 3.0)) for k, emphasis in enumerate(STYLES)]
MARKED = [replace(one, label=f"{one.label}, marked", marked=True) for one in EVERY]


def test_each_figure_is_a_file_of_each_format(tmp_path):
    files = save(figure(*EVERY), tmp_path)

    assert (
        [file.name for file in files]
        == [f"sample.{form}" for form in FORMATS]
        == ["sample.svg", "sample.png"]
    )
    assert set(tmp_path.iterdir()) == set(files)
    svg, png = (file.read_bytes() for file in files)
    assert b"<svg" in svg
    assert png.startswith(PNG)


@pytest.mark.parametrize("logarithmic", [False, True])
def test_nothing_but_greys(tmp_path, logarithmic):
    found = colours(drawn(figure(*EVERY, *MARKED, logarithmic=logarithmic), tmp_path))

    assert len(found) >= 4
    assert all(red == green == blue for red, green, blue in found)


def test_all_pixels_are_grey(tmp_path):
    from matplotlib.image import imread

    pixels = imread(save(figure(*EVERY, *MARKED), tmp_path)[1])

    assert pixels[..., :3].min() == 0
    assert (pixels[..., :1] == pixels[..., :3]).all()


def test_emphases_differ_in_line_as_well_as_in_grey():
    lines = {(style["linestyle"], style["linewidth"]) for style in STYLES.values()}

    assert len(lines) == len(STYLES)


def test_the_same_figure_gives_the_same_picture(tmp_path):
    first, second = tmp_path / "1", tmp_path / "2"
    pairs = []
    for directory in (first, second):
        directory.mkdir()
        pairs.append(save(figure(*EVERY), directory))

    assert pairs[0][1].read_bytes() == pairs[1][1].read_bytes()
    assert "<dc:date>" not in pairs[0][0].read_text(encoding="utf-8")
    names = re.compile(r"(?<=[\"#])[mp][0-9a-f]{10}(?=[\")])")
    assert len({names.sub("name", pair[0].read_text(encoding="utf-8")) for pair in pairs}) == 1


def test_the_same_figure_gives_the_same_bytes_as_svg(tmp_path):
    assert drawn(figure(*EVERY), tmp_path) == drawn(figure(*EVERY), tmp_path)


def test_labels_and_titles_stand_in_it_as_they_are(tmp_path):
    """Dollars would start a formula, and broken ones would be an error."""
    texts = ["cost in $", r"\alpha $x^2", "φ_1 · ω", "a & b < c"]
    panel = Panel(texts[1], texts[2], (curve(label=texts[3]),))
    found = written(drawn(Figure("texts", texts[0], "t in $s$", (panel,)), tmp_path))

    found = {text.replace(r"\$", "$").replace("&amp;", "&").replace("&lt;", "<") for text in found}
    assert {*texts, "t in $s$"} <= found


def test_nothing_of_a_file_can_control_anything(tmp_path):
    evil = "a\x1b[31m\u202e\n\x00--><script>alert(1)</script>"
    text = drawn(Figure(evil, evil, evil, (Panel(evil, evil, (curve(label=evil),)),)), tmp_path)

    assert not re.search(r"[\x00-\x08\x0b-\x1f\u202e]", text)
    assert [file.parent for file in tmp_path.rglob("*")] == [tmp_path] * 2


@pytest.mark.parametrize(
    ("name", "file"),
    [
        ("stages · turning-chi", "stages_turning-chi"),
        ("../../etc/passwd", "etc_passwd"),
        ("a/b\\c:d*e", "a_b_c_d_e"),
        ("φ_状態", "φ_状態"),
        ("..", "figure"),
        ("", "figure"),
        ("   ", "figure"),
        ("v1.2", "v1.2"),
    ],
)
def test_names_of_files(name, file):
    assert file_name(name) == file


@pytest.mark.parametrize(
    "curves",
    [
        [],
        [curve(y=(0.0, 0.0, 0.0))],
        [curve(y=(-1.0, -2.0, -3.0))],
        [curve(y=(float("nan"), 1.0, float("inf")))],
        [curve(y=(1e-200, 1e200, 1.0))],
        [curve(y=(5.0, 5.0, 5.0))],
        [Curve("one instant", (1.0,), (2.0,))],
    ],
    ids=["none", "zero", "negative", "not finite", "far apart", "constant", "one"],
)
@pytest.mark.parametrize("logarithmic", [False, True])
def test_odd_values_are_drawn_without_a_warning(tmp_path, curves, logarithmic):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert "<svg" in drawn(figure(*curves, logarithmic=logarithmic), tmp_path)


def _chi(report):
    return [one for one in report.figures() if one.name.endswith("-chi")]


def test_chi_is_shown_with_its_bound_at_every_instant(compared):
    figures = _chi(compared)
    verified = [one.verification for one in compared.results if one.verification]

    assert len(figures) == len(verified) == 2
    for shown, found in zip(figures, verified, strict=True):
        [panel] = shown.panels
        chi, bound = panel.curves
        assert (panel.logarithmic, panel.y_label, shown.x_label) == (True, "χ", "t")
        assert chi.x == bound.x == tuple(point.t for point in found.points)
        assert chi.y == tuple(point.chi for point in found.points)
        assert bound.y == tuple(point.bound for point in found.points)
        assert (chi.emphasis, bound.emphasis) == ("main", "limit")
        assert panel.title == f"{found.agree} of 3 instants agree"


def test_singular_values_are_shown_with_the_tolerance_of_the_rank(compared):
    shown = [one for one in compared.figures() if one.name.endswith("-singular-values")]

    assert len(shown) == 3
    for one in shown:
        [panel] = one.panels
        *values, tolerance = panel.curves
        assert (tolerance.emphasis, tolerance.label) == ("limit", "tolerance of the rank")
        assert tolerance.y == (6.1e-15,) * 3
        assert [curve.emphasis for curve in values] == ["main"] * 3 + ["one of many"] * (len(values) - 3)
        assert [curve.label for curve in values if curve.label] == ["counted as information", "dropped"]
        assert panel.logarithmic


def test_coefficients_are_shown_with_the_form_found_over_them(compared):
    for one in (one for one in compared.figures() if one.name.endswith("-coefficients")):
        assert [panel.title for panel in one.panels] == [
            "coefficient of b_a1 beside psi2",
            "coefficient of M_g11 beside psi2",
            "coefficient of b_g1 beside psi3",
        ]
        assert all(panel.curves[0].marked for panel in one.panels)


def test_a_checked_basis_has_its_own_figure(checked):
    assert [one.name for one in _chi(checked)] == ["sample · stage_1-chi", "sample · stage_1-claim-1-chi"]
    analysis, claimed = _chi(checked)
    assert max(analysis.panels[0].curves[0].y) == 0.1
    assert set(claimed.panels[0].curves[0].y) == {0.094}


def test_the_labels_of_the_report_stand_in_the_drawing(compared, tmp_path):
    found = written(drawn(_chi(compared)[0], tmp_path))

    assert {"χ, largest leak of a combination into the kernel", "what rounding may account for"} <= set(found)
    assert "2 of 3 instants agree" in found


def test_where_nothing_can_be_compared_there_is_no_figure(compared):
    from obscli.pipelines.describe.figures import chi_figure

    found = compared.results[0].verification
    empty = replace(found, points=tuple(replace(one, chi=None, bound=None) for one in found.points))

    assert list(chi_figure("name", "title", empty, "t")) == []
