"""LaTeX: a complete document whose body, between two comment lines, can be pasted into another."""

from __future__ import annotations

import re
from typing import Final

from obscli.core.document import (
    Block,
    Cell,
    Column,
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
from obscli.render.format import Format, Surface
from obscli.render.latex_text import in_math, in_text


HEAD: Final = r"""\documentclass{article}
\usepackage{iftex}
\ifPDFTeX\usepackage[utf8]{inputenc}\usepackage[@ENCODINGS@]{fontenc}\else\usepackage{fontspec}\fi
\usepackage{amsmath,amssymb,array,longtable}
\usepackage[margin=25mm]{geometry}
\setlength{\parindent}{0pt}
\begin{document}
% --- report: needs amsmath, amssymb, array, longtable ---
"""
FOOT: Final = r"""% --- end of report ---
\end{document}
"""
MARKS: Final[dict[Kind, str]] = {
    "good": r"$\checkmark$",
    "bad": r"$\times$",
    "open": r"\textbf{?}",
    "info": r"$\bullet$",
}
CYRILLIC: Final = re.compile("[\u0400-\u04ff]")
LETTERS: Final = {"left": "l", "right": "r", "centre": "c"}


def render(report: Report, surface: Surface) -> str:
    """Return the report as a LaTeX document."""
    blocks = report.document().flat(details=surface.details).blocks
    body = "\n".join(_block(block) for block in blocks)
    # the Cyrillic encoding is a package of its own, so it is asked for only where it is needed
    encodings = "T1,T2A" if CYRILLIC.search(body) else "T1"  # the last one is current
    return HEAD.replace("@ENCODINGS@", encodings) + body + "\n" + FOOT


def _block(block: Block) -> str:
    match block:
        case Heading(level, content):
            return rf"\{'sub' * (level - 1)}section*{{{_inline(content)}}}"
        case Paragraph(content):
            return _inline(content) + "\n"
        case Table():
            return _table(block)
        case Listing(items, numbered):
            kind = "enumerate" if numbered else "itemize"
            inner = "\n".join(rf"\item {_inline(item)}" for item in items)
            return rf"\begin{{{kind}}}" + "\n" + inner + "\n" + rf"\end{{{kind}}}"
        case VerdictLine(kind, content):
            return rf"{MARKS[kind]} {_inline(content)}" + "\n"
        case Note(kind, content):
            return (
                (r"\textbf{Warning:} " if kind == "warning" else "")
                + rf"\textit{{{_inline(content)}}}"
                + "\n"
            )
        case Details(blocks):
            return "\n".join(_block(inner) for inner in blocks)


def _table(table: Table) -> str:
    lines = [rf"\begin{{longtable}}{{@{{}}{_columns(table.columns)}@{{}}}}"]
    if any(column.title for column in table.columns):
        titles = " & ".join(rf"\textit{{{in_text(column.title)}}}" for column in table.columns)
        lines.append(titles + r" \\ \hline \endhead")
    lines += [
        " & ".join(_cell(cell, column) for cell, column in zip(row, table.columns, strict=True)) + r" \\"
        for row in table.rows
    ]
    lines.append(r"\end{longtable}")
    return "\n".join(lines) + (f"\n{_inline(table.caption)}\n" if table.caption else "")


def _columns(columns: tuple[Column, ...]) -> str:
    free = max(sum(column.breaks for column in columns), 1)
    share = 0.6 / free
    paragraph = rf">{{\raggedright\arraybackslash}}p{{{share:.2f}\linewidth}}"
    return "".join(paragraph if column.breaks else LETTERS[column.align] for column in columns)


def _cell(cell: Cell, column: Column) -> str:
    return (r" \newline " if column.breaks else "; ").join(_inline(content) for content in cell)


def _inline(content: Inline) -> str:
    return "".join(_part(part) for part in content)


def _part(part: Text | Math) -> str:
    if isinstance(part, Math):
        return f"${in_math(part.latex)}$"
    text = in_text(part.text)
    return {"name": rf"\texttt{{{text}}}", "strong": rf"\textbf{{{text}}}"}.get(part.role, text)


LATEX: Final = Format("latex", render)
