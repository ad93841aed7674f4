"""HTML: the report as one page that needs nothing else, with its figures drawn into it where asked for."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Final

from obscli.core.document import (
    Block,
    Cell,
    Column,
    Details,
    Document,
    Heading,
    Inline,
    Kind,
    Listing,
    Math,
    Note,
    Paragraph,
    Table,
    Text,
    VerdictLine,
)
from obscli.core.figure import Figure, HeatMap
from obscli.core.report import Report
from obscli.render.format import Format, Surface
from obscli.render.html_page import escaped, page


MARKS: Final[dict[Kind, str]] = {"good": "✓", "bad": "✗", "open": "?", "info": "•"}


def render(report: Report, surface: Surface) -> str:
    """Return the report as a page; details are folded away unless the surface shows them."""
    document = report.document()
    figures = _figures(report.figures()) if surface.figures else ()
    blocks = (_block(block, unfolded=surface.details) for block in document.blocks)
    return page(_title(document), [*blocks, *figures])


def _title(document: Document) -> str:
    """Return the title of the page: the first of its highest headings, and whether others follow."""
    headings = [block for block in document.blocks if isinstance(block, Heading)]
    titles = [one for one in headings if one.level == min(other.level for other in headings)]
    first = "".join(part.text for part in titles[0].content) if titles else "report"
    return first + ", …" * (len(titles) > 1) + " – obscli"


def _figures(figures: Iterable[Figure]) -> Iterator[str]:
    from obscli.render.figure import svg_element  # noqa: PLC0415 - the drawing library is heavy

    for k, figure in enumerate(figures, 1):
        if k == 1:
            yield "<h1>Figures</h1>"
        label = f'<svg role="img" aria-label="{escaped(figure.title)}"'
        svg = svg_element(figure, f"figure-{k}-").replace("<svg", label, 1)
        kind = "maps" if any(isinstance(one, HeatMap) for one in figure.panels) else "curves"
        yield f'<figure class="{kind}">\n{svg}\n</figure>'


def _block(block: Block, *, unfolded: bool) -> str:
    match block:
        case Heading(level, content):
            return f"<h{level}>{_inline(content)}</h{level}>"
        case Paragraph(content):
            return f"<p>{_inline(content)}</p>"
        case Table():
            return _table(block)
        case Listing(items, numbered):
            kind = "ol" if numbered else "ul"
            inner = "\n".join(f"<li>{_inline(item)}</li>" for item in items)
            return f"<{kind}>\n{inner}\n</{kind}>"
        case VerdictLine(kind, content):
            return f'<p class="verdict {kind}"><span class="sign">{MARKS[kind]}</span>{_inline(content)}</p>'
        case Note("warning", content):
            return f'<p class="note warning"><strong>Warning:</strong> {_inline(content)}</p>'
        case Note(_, content):
            return f'<p class="note">{_inline(content)}</p>'
        case Details(blocks):
            return _details(blocks, unfolded=unfolded)


def _details(blocks: tuple[Block, ...], *, unfolded: bool) -> str:
    """Return blocks that fold away under what introduces them: their first heading or paragraph."""
    summary = "Details"
    match blocks:
        case (Heading() as heading, *rest):
            summary, blocks = _block(heading, unfolded=unfolded), tuple(rest)
        case (Paragraph(content), *rest):
            summary, blocks = _inline(content), tuple(rest)
    inner = "\n".join(_block(block, unfolded=unfolded) for block in blocks)
    return f"<details{' open' * unfolded}>\n<summary>{summary}</summary>\n{inner}\n</details>"


def _table(table: Table) -> str:
    lines = ['<div class="table">', "<table>"]
    if table.caption:
        lines.append(f"<caption>{_inline(table.caption)}</caption>")
    if any(column.title for column in table.columns):
        titles = (f'<th scope="col"{_class(one)}>{escaped(one.title)}</th>' for one in table.columns)
        lines.append(f"<thead>\n<tr>{''.join(titles)}</tr>\n</thead>")
    lines.append("<tbody>")
    for row in table.rows:
        cells = (f"<td{_class(one)}>{_cell(cell)}</td>" for cell, one in zip(row, table.columns, strict=True))
        lines.append(f"<tr>{''.join(cells)}</tr>")
    return "\n".join([*lines, "</tbody>", "</table>", "</div>"])


def _class(column: Column) -> str:
    names = [column.align] * (column.align != "left") + ["breaks"] * column.breaks
    return f' class="{" ".join(names)}"' if names else ""


def _cell(cell: Cell) -> str:
    return "<br>".join(_inline(content) for content in cell)


def _inline(content: Inline) -> str:
    return "".join(_part(part) for part in content)


def _part(part: Text | Math) -> str:
    text = escaped(part.text)
    if isinstance(part, Math):
        return f'<code class="math">{text}</code>'
    if part.role == "plain" or not text:
        return text
    tag = {"name": "code", "strong": "strong"}.get(part.role, "span")
    return f'<{tag} class="{part.role}">{text}</{tag}>'


HTML: Final = Format("html", render)
