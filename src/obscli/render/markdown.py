"""Markdown (GitHub's, as notebooks read it too): headings, tables, formulas between dollars."""

from __future__ import annotations

import re
from typing import Final

from obscli.core.document import (
    Align,
    Block,
    Cell,
    Details,
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
from obscli.core.report import Report
from obscli.core.visible import visible
from obscli.render.format import Format, Surface


RULES: Final[dict[Align, str]] = {"left": ":---", "right": "---:", "centre": ":---:"}
MARKS: Final[dict[Kind, str]] = {"good": "✓", "bad": "✗", "open": "?", "info": "•"}

#: What would end a formula, a table cell or the text itself inside one.
IN_MATH: Final = {"|": r"\vert ", "$": r"\$", "`": r"\grave{}", "<": r"\lt ", ">": r"\gt "}


def render(report: Report, surface: Surface) -> str:
    """Return the report in Markdown."""
    blocks = report.document().flat(details=surface.details).blocks
    return "\n\n".join(_block(block) for block in blocks) + "\n"


def _block(block: Block) -> str:
    match block:
        case Heading(level, content):
            return "#" * (level + 1) + " " + _inline(content)
        case Paragraph(content):
            return _inline(content)
        case Table():
            return _table(block)
        case Listing(items, numbered):
            marks = (f"{k}." if numbered else "-" for k in range(1, len(items) + 1))
            return "\n".join(f"{mark} {_inline(item)}" for mark, item in zip(marks, items, strict=True))
        case VerdictLine(kind, content):
            return f"{MARKS[kind]} {_inline(content)}"
        case Note(kind, content):
            return f"> **Warning:** {_inline(content)}" if kind == "warning" else f"> {_inline(content)}"
        case Details(blocks):
            return "\n\n".join(_block(inner) for inner in blocks)


def _table(table: Table) -> str:
    rows = [
        "| " + " | ".join(escaped(column.title) for column in table.columns) + " |",
        "| " + " | ".join(RULES[column.align] for column in table.columns) + " |",
        *("| " + " | ".join(_cell(cell) for cell in row) + " |" for row in table.rows),
    ]
    return "\n".join(rows) + (f"\n\n{_inline(table.caption)}" if table.caption else "")


def _cell(cell: Cell) -> str:
    return "<br>".join(_inline(content) for content in cell)


def _inline(content: Inline) -> str:
    return "".join(_part(part) for part in content)


def _part(part: Text | Math) -> str:
    if isinstance(part, Math):
        return "$" + "".join(IN_MATH.get(c, c) for c in visible(part.latex)) + "$"
    lead, body, tail = _margins(part.text)
    if not body or part.role not in ("name", "strong"):
        return lead + escaped(body) + tail
    return lead + (_code(body) if part.role == "name" else f"**{escaped(body)}**") + tail


def _margins(text: str) -> tuple[str, str, str]:
    body = text.strip(" ")
    start = text.find(body) if body else len(text)
    return text[:start], body, text[start + len(body) :]


def escaped(text: str) -> str:
    """Return the text so that Markdown and the HTML it allows show it as it is."""
    text = re.sub(r"([\\`*_\[\]|~$])", r"\\\1", visible(text))
    text = text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return re.sub(r"^(\d*)([-+#=.)])", r"\1\\\2", text)


def _code(text: str) -> str:
    fence = "`" * (max((len(run) for run in re.findall("`+", text)), default=0) + 1)
    space = " " * ("`" in text)
    return fence + space + visible(text).replace("|", r"\|") + space + fence


MARKDOWN: Final = Format("markdown", render)
