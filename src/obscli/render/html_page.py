"""The frame of an HTML page: a stylesheet of its own, nothing from elsewhere, no script allowed."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from typing import Final

from obscli.core.visible import visible


STYLE: Final = """\
:root { color-scheme: light; }
body { margin: 0; background: #fff; color: #1a1a1a; font: 1rem/1.5 system-ui, sans-serif; }
main { max-width: 62rem; margin: 0 auto; padding: 1.5rem 1.25rem 3rem; }
h1, h2 { line-height: 1.25; font-weight: 600; }
h1 { font-size: 1.6rem; margin: 3rem 0 1rem; padding-bottom: .3rem; border-bottom: 2px solid; }
h1:first-child { margin-top: 0; }
h2 { font-size: 1.15rem; margin: 2rem 0 .5rem; }
p { margin: .5rem 0; overflow-wrap: break-word; }
code { font: .92em/1.45 ui-monospace, Menlo, Consolas, monospace; }
.table { overflow-x: auto; margin: .75rem 0; }
table { border-collapse: collapse; min-width: min(100%, 36rem); }
caption { caption-side: bottom; text-align: left; padding-top: .4rem; font-size: .9rem; }
th, td { padding: .2rem .9rem .2rem 0; text-align: left; vertical-align: top; }
th, td { white-space: nowrap; width: 1%; }
th { font-weight: 600; border-bottom: 1px solid #1a1a1a; }
td { border-bottom: 1px solid #e4e4e4; font-variant-numeric: tabular-nums; }
.breaks { white-space: normal; overflow-wrap: break-word; width: auto; min-width: 8rem; }
.right { text-align: right; }
.centre { text-align: center; }
td .math { display: inline-block; padding-left: 1.5em; text-indent: -1.5em; }
td .good, td .open, td .bad { display: inline-block; min-width: 1em; text-align: center; }
ul, ol { margin: .5rem 0; padding-left: 2rem; }
.verdict { padding-left: 1.5rem; text-indent: -1.5rem; }
.sign { display: inline-block; width: 1.5rem; text-indent: 0; font-weight: 700; }
.note { border-left: 3px solid #bbb; padding-left: .75rem; }
.warning { border-left-color: #8a5a00; }
.faint { color: #595959; }
span.good, .good > .sign { color: #0b6b2e; }
span.open, .open > .sign { color: #8a5a00; }
span.bad, .bad > .sign { color: #b00020; }
details { margin: .75rem 0; }
summary { cursor: pointer; }
summary > h2 { display: inline; }
figure { margin: 1.5rem 0; }
figure svg { max-width: 100%; height: auto; }
@media print {
  @page { margin: 12mm; }
  html { font-size: 10pt; }
  main { max-width: none; padding: 0; }
  h1, h2, summary { break-after: avoid; }
  tr, li, .verdict, .note, figure { break-inside: avoid; }
  figure { margin: 0; }
  .curves svg { max-height: 250mm; }
  .table { overflow: visible; }
  .breaks { overflow-wrap: anywhere; }
}"""

#: The page may style itself and do nothing else, whatever stands in it.
POLICY: Final = "default-src 'none'; style-src 'unsafe-inline'"


def page(title: str, blocks: Iterable[str]) -> str:
    """Return a page of blocks that are HTML already."""
    lines = [
        "<!DOCTYPE html>",
        '<html lang="en">',
        "<head>",
        '<meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">',
        f"<title>{escaped(title)}</title>",
        f"<style>\n{STYLE}\n</style>",
        "</head>",
        "<body>",
        "<main>",
        *blocks,
        "</main>",
        "</body>",
        "</html>",
    ]
    return "\n".join(lines) + "\n"


def escaped(text: str) -> str:
    """Return the text so that HTML shows it as it is, between tags and in attributes."""
    return escape(visible(text), quote=True)
