"""The output formats obscli knows: one line each."""

from __future__ import annotations

from typing import Final

from obscli.render.format import Format
from obscli.render.html import HTML
from obscli.render.json_text import JSON
from obscli.render.latex import LATEX
from obscli.render.markdown import MARKDOWN
from obscli.render.terminal import TERMINAL


FORMATS: Final[tuple[Format, ...]] = (TERMINAL, JSON, MARKDOWN, LATEX, HTML)


def format_named(name: str) -> Format:
    """Return the format of that name; KeyError where there is none."""
    return {one.name: one for one in FORMATS}[name]
