"""A line of text in pieces, each in its role: the common coin of the terminal's layout."""

from __future__ import annotations

import unicodedata
from typing import TypeAlias

from obscli.core.document import Role


Piece: TypeAlias = tuple[str, Role]
Line: TypeAlias = tuple[Piece, ...]


def cell_width(text: str) -> int:
    """Return how many terminal cells the text takes."""
    if text.isascii():
        return len(text)
    return sum(_character_width(character) for character in text)


def _character_width(character: str) -> int:
    if unicodedata.combining(character):
        return 0
    return 2 if unicodedata.east_asian_width(character) in "WF" else 1


def line_width(line: Line) -> int:
    """Return how many terminal cells the line takes."""
    return sum(cell_width(text) for text, _ in line)


def line_text(line: Line) -> str:
    """Return the bare text of the line, without trailing blanks."""
    return "".join(text for text, _ in line).rstrip(" ")


def indented(lines: list[Line], first: str, rest: str, role: Role = "plain") -> list[Line]:
    """Return the lines with ``first`` (in ``role``) before the first and ``rest`` before the others."""
    return [(((first, role) if k == 0 else (rest, "plain")), *line) for k, line in enumerate(lines)]
