"""Figures: one SVG and one PNG each, told apart without colour, what they show taken from the report."""

import re
import warnings
from dataclasses import replace

import pytest

from obscli.core.figure import Curve, Figure, HeatMap, Panel
from obscli.render.figure import FORMATS, STYLES, file_name, save, svg_element
from obscli.render.heat_map import heights, natural_width


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


def heat_map(rows=("r1", "r2"), columns=("c1", "c2", "c3"), value=0.5, text="", title="", legend="known"):
    """Return a map whose value and text are the same everywhere, or given by functions of i and j."""

    def cells(one):
        return tuple(
            tuple(one(i, j) if callable(one) else one for j in range(len(columns))) for i in range(len(rows))
        )

    return HeatMap(title, rows, columns, cells(value), cells(text), legend)


def mapped(*panels, name="map"):
    return Figure(name, "A map", "t", panels)


def mesh(svg):
    """Return the fill of every cell of the maps of a drawing, row after row."""
    [part] = re.findall(r'<g id="QuadMesh_\d+">(.*?)</g>', svg, re.DOTALL)
    return [
        int(colour, 16) if colour else None
        for colour in re.findall(r"<path [^>]*?(?:fill: (?:#(..)\1\1|none))", part)
    ]


def size(svg):
    return tuple(float(one) for one in re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', svg).groups())


def test_darker_is_more_and_nothing_is_transparent(tmp_path):
    values = [0.0, 0.1, 0.5, 0.9, 1.0, None]
    shown = heat_map(("a", "b"), ("c", "d", "e"), lambda i, j: values[3 * i + j])
    svg = drawn(mapped(shown), tmp_path)
    *greys, missing = mesh(svg)

    assert greys == sorted(greys, reverse=True)
    assert greys[0] == 255
    assert 0 < greys[-1] < 40
    assert missing is None
    assert "<pattern" in svg
    assert any("no value" in text for text in written(svg))


def test_where_every_cell_has_a_value_nothing_is_hatched(tmp_path):
    svg = drawn(mapped(heat_map()), tmp_path)

    assert "<pattern" not in svg
    assert not any("no value" in text for text in written(svg))


def test_writing_stands_out_from_its_cell(tmp_path):
    """At least 4.5 to 1, which is what small print needs."""
    values = [k / 20 for k in range(21)]
    names = tuple(f"c{k}" for k in range(21))
    texts = [f"{k}.{k}" for k in range(21)]
    shown = heat_map(("row",), names, lambda _, j: values[j], lambda _, j: texts[j])
    svg = drawn(mapped(shown), tmp_path)

    def light(grey):
        part = grey / 255
        return part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4

    for text, cell in zip(texts, mesh(svg), strict=True):
        ink = re.search(rf"<!-- {re.escape(text)} -->\s*<g(?: style=\"fill: #(..))?", svg).group(1)
        low, high = sorted([light(cell), light(int(ink or "00", 16))])
        assert (high + 0.05) / (low + 0.05) > 4.5


def test_a_map_is_grey_and_its_words_stand_in_it(tmp_path):
    shown = heat_map(
        value=lambda i, j: None if i == j else 0.7,
        text=lambda i, j: f"{i}+{j}",
        title="$ of a map",
        legend="well known",
    )
    svg = drawn(mapped(shown), tmp_path)

    assert all(red == green == blue for red, green, blue in colours(svg))
    found = " ".join(written(svg)).replace(r"\$", "$")
    words = {"$ of a map", "well known", "A map", *shown.rows, *shown.columns}
    assert all(word in found for word in words)
    assert {text for row in shown.texts for text in row} <= set(written(svg))


def test_texts_are_written_only_where_they_fit(tmp_path):
    words = {True: "2.5", False: "a text that is much longer than its cell could ever be"}
    shown = heat_map(("r",) * 3, tuple("abcdefghij"), text=lambda i, j: words[(i + j) % 2 == 0])
    found = written(drawn(mapped(shown), tmp_path))

    assert found.count(words[True]) == 15
    assert words[False] not in found


@pytest.mark.parametrize(("rows", "columns"), [(21, 24), (168, 6)])
def test_the_canvas_grows_with_the_cells(tmp_path, rows, columns):
    labels = tuple(f"state {k}" for k in range(rows)), tuple(f"M_g{k}" for k in range(columns))
    small = size(drawn(mapped(heat_map()), tmp_path))
    svg = drawn(mapped(heat_map(*labels, text="0.25")), tmp_path)
    width, height = size(svg)

    assert height - small[1] >= 12 * (rows - 2)
    assert width >= max(small[0], 15 * columns)
    assert written(svg).count("0.25") == rows * columns
    assert set(labels[0]) | set(labels[1]) <= set(written(svg))


def test_long_names_of_columns_are_upright(tmp_path):
    for name, turned in (("c", 0), ("a rather long name of a column", 1)):
        svg = drawn(mapped(heat_map(("r",), (name,) * 6)), tmp_path)
        assert len(re.findall(rf"<!-- {name} -->\s*<g [^>]*rotate\(-90\)", svg)) == 6 * turned


def test_panels_share_their_abscissa_and_maps_do_not(tmp_path):
    """The last panel has the numbers and the label of the abscissa, wherever maps stand."""
    panel = Panel("", "y", (Curve("", (1000.0, 3000.0), (1.0, 2.0)),))
    alone = written(drawn(mapped(panel), tmp_path))
    found = written(drawn(mapped(panel, heat_map(), panel, heat_map(columns=("d1", "d2"))), tmp_path))

    assert found.count("3000") == alone.count("3000") == 1
    assert found.count("t") == 1
    assert {"c1", "c2", "c3", "d1", "d2"} <= set(found)


def test_the_same_map_gives_the_same_bytes(tmp_path):
    shown = mapped(heat_map(value=lambda i, j: None if i == j else 0.3, text="x"), Panel("", "y", (curve(),)))
    first = drawn(shown, tmp_path), svg_element(shown, "a-")
    second = drawn(shown, tmp_path), svg_element(shown, "a-")

    assert first == second


@pytest.mark.parametrize(
    "shown",
    [
        heat_map((), ()),
        heat_map(columns=()),
        heat_map(rows=()),
        heat_map(value=None),
        heat_map(value=float("nan")),
        heat_map(value=1.0),
        heat_map(rows=("r" * 5000,), columns=("c" * 5000,) * 2, title="t " * 500, legend="l" * 500),
        heat_map(rows=("φ_ширина", "\u202e\x1b"), text="$\n"),
    ],
    ids=["empty", "no columns", "no rows", "no values", "not numbers", "dark", "long names", "strange names"],
)
def test_odd_maps_are_drawn_without_a_warning(tmp_path, shown):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        svg = drawn(mapped(shown), tmp_path)
    assert "<svg" in svg
    assert max(size(svg)) < 72 * 20


def test_a_very_long_map_shrinks_its_cells():
    """No drawing library takes pictures of any size."""
    names = tuple(str(k) for k in range(10_000))

    assert sum(heights(heat_map(names, ("c",)), 6.4)) < 110
    assert natural_width(heat_map(("r",), names)) < 110


@pytest.mark.parametrize("panel", [Panel("", "y", tuple(EVERY)), heat_map(value=None, text="–")])
def test_an_element_for_a_page_names_nothing_outside_and_all_inside_by_its_prefix(panel):
    text = svg_element(mapped(panel), "figure-7-")

    assert text.startswith("<svg ")
    assert text.endswith("</svg>")
    assert not re.search(r"https?:|<!--|<!DOCTYPE|<\?|<metadata", text)
    ids = re.findall(r'\bid="([^"]*)"', text)
    assert len(ids) == len(set(ids))
    assert all(one.startswith("figure-7-") for one in ids)
    referred = re.findall(r'href="#?([^"]*)"|url\(#?([^)]*)\)', text)
    assert referred
    assert {a or b for a, b in referred} <= set(ids)


def test_an_element_for_a_page_shows_what_the_file_shows(tmp_path):
    """Same shapes; only names, comments and what a file says of itself differ."""
    shown = mapped(Panel("", "y", tuple(EVERY)), heat_map(text="x"))
    shapes = [re.findall(r' d="([^"]*)"', one) for one in (drawn(shown, tmp_path), svg_element(shown, "p-"))]

    assert shapes[0] == shapes[1] != []
