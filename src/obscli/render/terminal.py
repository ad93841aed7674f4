"""The report for a terminal: plain lines that fit the width, colour only as an extra."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from obscli.core.document import (
    Block,
    Details,
    Heading,
    Inline,
    Kind,
    Listing,
    Note,
    Paragraph,
    Role,
    Table,
    Text,
    VerdictLine,
)
from obscli.core.report import Report
from obscli.render.format import Format, Surface
from obscli.render.line import Line, indented, line_text, line_width
from obscli.render.table import table_lines
from obscli.render.wrap import wrap


#: Everything below a heading of level 2 stands this far to the right.
INDENT: Final = "  "

NARROWEST: Final = 40
MARKS: Final[dict[Kind, tuple[str, Role]]] = {
    "good": ("✓", "good"),
    "bad": ("✗", "bad"),
    "open": ("?", "open"),
    "info": ("•", "faint"),
}


def render(report: Report, surface: Surface) -> str:
    """Return the report in lines of at most the surface's width, as far as words can be broken."""
    lines = list(document_lines(report.document().flat(details=surface.details).blocks, surface.width))
    if surface.colour:
        from obscli.render.colour import coloured  # noqa: PLC0415 - only a terminal pays for rich

        return coloured(lines)
    return "".join(line_text(line) + "\n" for line in lines)


def document_lines(blocks: tuple[Block, ...], width: int) -> Iterator[Line]:
    """Yield the lines of the blocks."""
    width = max(width, NARROWEST)
    before: Block | None = None
    for block in blocks:
        yield from [()] * _gap(before, block)
        yield from _block_lines(block, width)
        before = block


def _gap(before: Block | None, block: Block) -> int:
    """Return how many empty lines stand between two blocks."""
    match before, block:
        case None, _:
            return 0
        case _, Heading(level):
            return 3 - level
        case Paragraph(), Table():
            return 1
    return 0


def _block_lines(block: Block, width: int) -> list[Line]:
    inner = width - len(INDENT)
    match block:
        case Heading():
            return _heading(block, width)
        case Paragraph(content):
            return indented(wrap(content, inner, hang=0), INDENT, INDENT)
        case Table():
            caption = wrap(block.caption, inner, hang=0) if block.caption else []
            return indented(table_lines(block, inner) + caption, INDENT, INDENT)
        case Listing(items, numbered):
            return [
                line
                for k, item in enumerate(items, 1)
                for line in _marked(item, f"{k}." if numbered else "-", width)
            ]
        case VerdictLine(kind, content):
            mark, role = MARKS[kind]
            return _marked(content, mark, width, role)
        case Note(kind, content):
            warning: Inline = (Text("warning: ", "open"), *content)
            return _marked(warning, "!", width, "open") if kind == "warning" else _marked(content, "•", width)
        case Details(blocks):
            return list(document_lines(blocks, width))


def _heading(heading: Heading, width: int) -> list[Line]:
    strong = tuple(Text(part.text, "strong") for part in heading.content)
    lines = wrap(strong, width)
    if heading.level == 1:
        lines.append((("─" * max(line_width(line) for line in lines), "faint"),))
    return lines


def _marked(content: Inline, mark: str, width: int, role: Role = "plain") -> list[Line]:
    first = f"{INDENT}{mark} "
    rest = " " * len(first)
    return indented(wrap(content, width - len(first), hang=2), first, rest, role)


TERMINAL: Final = Format("terminal", render)
