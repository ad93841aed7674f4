"""The page: well formed, closed to the outside, nothing of a file in it but as text, figures only where asked for."""

import re
from dataclasses import dataclass, field
from html.parser import HTMLParser

import pytest

from obscli.core.document import (
    Column,
    Details,
    Document,
    Heading,
    Listing,
    Math,
    Note,
    Paragraph,
    Table,
    Text,
    VerdictLine,
    line,
    plain,
)
from obscli.core.figure import Curve, Figure, HeatMap, Panel
from obscli.core.visible import visible
from obscli.render.format import Surface
from obscli.render.html import render


VOID = {"meta", "br"}
TAGS = {
    *(
        "html",
        "head",
        "meta",
        "title",
        "style",
        "body",
        "main",
        "h1",
        "h2",
        "p",
        "ul",
        "ol",
        "li",
        "div",
        "br",
    ),
    *("table", "caption", "thead", "tbody", "tr", "th", "td", "code", "strong", "span", "details", "summary"),
    "figure",
}
EVIL = "<script>alert('1')</script> & \"quoted\" &lt; \x1b[31m \u202e\n\x00 <!-- ]]> </style></title></code>"


@dataclass
class Stub:
    """A report of given blocks and figures."""

    blocks: tuple = ()
    drawn: tuple = ()
    asked: list = field(default_factory=list)

    def document(self):
        return Document(tuple(self.blocks))

    def figures(self):
        self.asked.append("figures")
        return self.drawn


class Page(HTMLParser):
    """Reads a page, and fails where a tag is not closed, or closed twice."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.open, self.tags, self.attributes, self.texts = [], [], [], []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += [(tag, *pair) for pair in attrs]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        assert "svg" in self.open, tag
        self.tags.append(tag)
        self.attributes += [(tag, *pair) for pair in attrs]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append(((self.open or [""])[-1], data))

    def text(self, tag):
        return [text for inside, text in self.texts if inside == tag]


def page(*blocks, **surface):
    return render(Stub(blocks), Surface(**surface))


def figure(name="alike", title="A figure"):
    curve = Curve("", (0.0, 1.0), (1.0, 2.0), marked=True)
    heat = HeatMap("", ("r",), ("c", "d"), ((0.5, None),), (("x", "–"),), "dark")
    return Figure(name, title, "t", (Panel("", "y", (curve,)), heat))


@pytest.mark.parametrize("kind", ["report", "compared", "checked", "hostile"])
@pytest.mark.parametrize("details", [False, True])
@pytest.mark.parametrize("figures", [False, True])
def test_every_report_is_a_well_formed_page(request, kind, details, figures):
    text = render(request.getfixturevalue(kind), Surface(details=details, figures=figures))
    found = Page(text)

    assert text.startswith("<!DOCTYPE html>\n")
    assert [found.tags.count(tag) for tag in ("html", "head", "title", "body", "main")] == [1] * 5
    drawing = set(found.tags) - TAGS
    assert ("svg" in drawing) == (figures and kind in ("compared", "checked"))
    assert drawing <= {"svg", "g", "defs", "path", "use", "style", "clippath", "rect", "pattern"}


@pytest.mark.parametrize("kind", ["report", "compared", "checked", "hostile"])
def test_the_page_needs_and_reaches_nothing_else(request, kind):
    text = render(request.getfixturevalue(kind), Surface(details=True, figures=True))

    assert not re.search(r"https?:|//|@import|data:|<script|<link|<iframe|<img|javascript:", text)
    for _, name, value in Page(text).attributes:
        assert not name.startswith("on")
        if name in {"href", "xlink:href", "src", "action"}:
            assert value.startswith("#")
    assert all(re.match(r"url\(#", one) for one in re.findall(r"url\([^)]*\)", text))
    assert """content="default-src 'none'; style-src 'unsafe-inline'">""" in text


BLOCKS = {
    "heading": Heading(1, plain(EVIL)),
    "section": Heading(2, (Text(EVIL, "strong"),)),
    "paragraph": Paragraph((Text(EVIL, "name"), Text(EVIL, "faint"), Math(EVIL, EVIL))),
    "table": Table((Column(EVIL), Column(EVIL, "right", breaks=True)), ((line(Text(EVIL)), line(Math(EVIL, ""))),), plain(EVIL)),
    "listing": Listing((plain(EVIL), (Math(EVIL, EVIL),))),
    "verdict": VerdictLine("bad", plain(EVIL)),
    "note": Note("note", plain(EVIL)),
    "warning": Note("warning", plain(EVIL)),
    "details": Details((Paragraph(plain(EVIL)), Paragraph(plain(EVIL)))),
}  # fmt: skip


@pytest.mark.parametrize("block", BLOCKS.values(), ids=BLOCKS.keys())
def test_a_hostile_text_is_only_text(block):
    text = page(block)
    found = Page(text)

    assert set(found.tags) <= TAGS
    assert "<script" not in text
    assert not re.search(r"[\x00-\x09\x0b-\x1f\u202e]", text)
    assert any(visible(EVIL) in one for _, one in found.texts)
    body = text[text.index("<main>") :]
    assert len(re.findall(r"&(?!(amp|lt|gt|quot|#x27);)", body)) == 0


def test_a_hostile_figure_is_only_a_drawing():
    text = render(Stub((), (figure(EVIL, EVIL),)), Surface(figures=True))
    found = Page(text)

    assert "script" not in found.tags
    assert not re.search(r"[\x00-\x09\x0b-\x1f\u202e]", text)
    [label] = [value for tag, name, value in found.attributes if (tag, name) == ("svg", "aria-label")]
    assert label == visible(EVIL)


def test_figures_are_drawn_if_and_only_if_asked_for():
    stub = Stub((Heading(1, plain("A")),), (figure(), figure()))

    assert "<svg" not in render(stub, Surface(details=True))
    assert stub.asked == []
    text = render(stub, Surface(figures=True))
    assert Page(text).text("h1") == ["A", "Figures"]
    assert text.count("<svg") == 2
    assert text.index("Figures</h1>") < text.index("<svg")
    assert "Figures" not in render(Stub(), Surface(figures=True))


def test_figures_of_one_name_do_not_share_an_id():
    text = render(Stub((), (figure(), figure())), Surface(figures=True))
    ids = [value for _, name, value in Page(text).attributes if name == "id"]

    assert len(ids) == len(set(ids)) > 20
    referred = re.findall(r'href="#([^"]*)"', text) + re.findall(r"url\(#([^)]*)\)", text)
    assert referred
    assert set(referred) <= set(ids)


def test_the_same_report_gives_the_same_bytes(compared):
    surface = Surface(details=True, figures=True)

    assert render(compared, surface) == render(compared, surface)


def test_the_title_is_that_of_the_report():
    one, two = Heading(1, plain("a & b")), Heading(1, plain("c"))

    assert Page(page(one, Heading(2, plain("x")))).text("title") == ["a & b – obscli"]
    assert Page(page(one, two)).text("title") == ["a & b, … – obscli"]
    assert Page(page(Heading(2, plain("x")))).text("title") == ["x – obscli"]
    assert Page(page()).text("title") == ["report – obscli"]


def test_tables_have_captions_headings_and_columns_of_their_kind():
    columns = (Column("n", "right"), Column("what", breaks=True), Column("", "centre"))
    two_lines = (plain("first"), (Math("a*b", ""),))
    text = page(Table(columns, ((line(Text("1")), two_lines, line(Text("✓", "good"))),), plain("about it")))

    assert "<caption>about it</caption>" in text
    assert '<th scope="col" class="right">n</th><th scope="col" class="breaks">what</th>' in text
    assert '<td class="right">1</td><td class="breaks">first<br><code class="math">a*b</code></td>' in text
    assert '<td class="centre"><span class="good">✓</span></td>' in text
    untitled = page(Table((Column(), Column()), ((line(Text("a")), line(Text("b"))),)))
    assert "<thead>" not in untitled
    assert "<caption>" not in untitled


def test_verdicts_have_a_sign_as_well_as_a_colour():
    kinds = {"good": "✓", "bad": "✗", "open": "?", "info": "•"}
    found = Page(page(*(VerdictLine(kind, plain(f"it is {kind}")) for kind in kinds)))

    assert found.text("span") == list(kinds.values())
    assert [value for tag, name, value in found.attributes if tag == "p"] == [
        f"verdict {kind}" for kind in kinds
    ]


def test_roles_are_classes_and_empty_text_leaves_no_tag():
    roles = ("plain", "strong", "name", "faint", "good", "open", "bad")
    text = page(Paragraph(tuple(Text(role, role) for role in roles)), Paragraph((Text("", "bad"),)))

    assert (
        '<p>plain<strong class="strong">strong</strong><code class="name">name</code><span class="faint">faint</span>'
        '<span class="good">good</span><span class="open">open</span><span class="bad">bad</span></p>\n<p></p>'
    ) in text


def test_details_fold_away_under_what_introduces_them():
    inner = Paragraph(plain("inner"))
    blocks = (
        Details((Heading(2, plain("titled")), inner)),
        Details((Paragraph(plain("said")), inner)),
        Details((Listing((plain("item"),)), inner)),
        Details(()),
    )
    folded, unfolded = page(*blocks), page(*blocks, details=True)

    assert "<summary><h2>titled</h2></summary>\n<p>inner</p>\n</details>" in folded
    assert "<summary>said</summary>\n<p>inner</p>\n</details>" in folded
    assert "<summary>Details</summary>\n<ul>" in folded
    assert folded.count("<details>") == unfolded.count("<details open>") == 4
    assert unfolded.replace("<details open>", "<details>") == folded
