"""Breaking running text and formulas into lines: text at blanks, formulas before + and -.

A formula too long for a line is broken at its outermost signs, with a hanging indent; a term that is itself
too long, at inner signs, then after ``*``, then anywhere.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from obscli.core.document import Inline, Math, Role
from obscli.core.visible import visible
from obscli.render.line import Line, Piece, cell_width


@dataclass(frozen=True, slots=True)
class Chunk:
    """Text kept on one line; ``blank`` before it unless it starts one; ``hangs`` if inside a formula."""

    text: str
    role: Role
    blank: bool
    hangs: bool = False


def wrap(content: Inline, width: int, hang: int = 2) -> list[Line]:
    """Return the content in lines of at most ``width`` cells, continued formulas indented by ``hang``."""
    width = max(width, 1)
    hang = min(hang, width - 1)
    lines: list[Line] = []
    pieces: list[Piece] = []
    used = 0
    for chunk in _chunks(content, width, width - hang):
        text = " " * (chunk.blank and used > 0) + chunk.text
        if used and used + cell_width(text) > width:
            lines.append(tuple(pieces))
            pieces, used = ([(" " * hang, "plain")], hang) if chunk.hangs else ([], 0)
            text = chunk.text
        pieces.append((text, chunk.role))
        used += cell_width(text)
    lines.append(tuple(pieces))
    return lines


def _chunks(content: Inline, width: int, hanging: int) -> Iterator[Chunk]:
    blank = False
    for part in content:
        text = visible(part.text)
        if isinstance(part, Math):
            yield from _formula(text, hanging, blank=blank)
            blank = False
            continue
        blank = blank or text.startswith(" ")
        for word in text.split():
            for k, bit in enumerate(_cut(word, width)):
                yield Chunk(bit, part.role, blank and k == 0)
            blank = True
        blank = text.endswith(" ")


def _formula(text: str, width: int, *, blank: bool) -> Iterator[Chunk]:
    for k, term in enumerate(_outer_terms(text)):
        yield from _fitted(term, width, blank=blank if k == 0 else True, first=k == 0)


def _fitted(term: str, width: int, *, blank: bool, first: bool) -> Iterator[Chunk]:
    """Yield the term whole where it fits, else in parts that do."""
    for k, part in enumerate([term] if cell_width(term) <= width else re.split(r" (?=[+-] )", term)):
        factors = [part] if cell_width(part) <= width else re.split(r"(?<=[*,])(?=[^*])", part)
        bits = [bit for factor in factors for bit in _cut(factor.strip(), width)]
        for j, bit in enumerate(bits):
            yield Chunk(bit, "plain", j == 0 and (blank or k > 0), hangs=not first or k > 0 or j > 0)


def _outer_terms(text: str) -> list[str]:
    """Split outside all brackets after commas, or where there are none before signs between blanks."""
    blanks = list(_outer_blanks(text))
    commas = [k for k in blanks if text[k - 1 : k] == ","]
    ends = commas or [k for k in blanks if text[k + 1 : k + 3] in ("+ ", "- ")]
    starts = [0, *(k + 1 for k in ends)]
    return [text[start:end] for start, end in zip(starts, [*ends, len(text)], strict=True)]


def _outer_blanks(text: str) -> Iterator[int]:
    depth = 0
    for k, character in enumerate(text):
        if character in "([{":
            depth += 1
        elif character in ")]}":
            depth -= 1
        elif character == " " and depth <= 0:
            yield k


def _cut(word: str, width: int) -> Iterator[str]:
    while cell_width(word) > width:
        end = width
        while end > 1 and cell_width(word[:end]) > width:
            end -= 1
        yield word[:end]
        word = word[end:]
    yield word
