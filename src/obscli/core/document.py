"""The neutral document: what a report says, before any format says it in its own way.

A finding becomes a document once (N describers), a document becomes text once per format (M renderers).
Text in a document is raw: every renderer escapes it for its own format. Nothing here knows algebra.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias


#: How a piece of running text stands out; every format must stay readable without it.
Role: TypeAlias = Literal["plain", "strong", "name", "faint", "good", "open", "bad"]

#: What a verdict says: it holds, it does not, it is open, or it merely informs.
Kind: TypeAlias = Literal["good", "bad", "open", "info"]

Align: TypeAlias = Literal["left", "right", "centre"]


@dataclass(frozen=True, slots=True)
class Text:
    """Running text in one role."""

    text: str
    role: Role = "plain"


@dataclass(frozen=True, slots=True)
class Math:
    """A formula: as text in the grammar of the model file, and in LaTeX without the dollars."""

    text: str
    latex: str


Inline: TypeAlias = tuple[Text | Math, ...]

#: The content of a table cell: one or more lines.
Cell: TypeAlias = tuple[Inline, ...]


@dataclass(frozen=True, slots=True)
class Heading:
    """A heading; level 1 opens a stage, level 2 a section of it."""

    level: Literal[1, 2]
    content: Inline


@dataclass(frozen=True, slots=True)
class Paragraph:
    """Running text."""

    content: Inline


@dataclass(frozen=True, slots=True)
class Column:
    """How a table column is set: its heading (may be empty), alignment, whether its cells may be broken."""

    title: str = ""
    align: Align = "left"
    breaks: bool = False


@dataclass(frozen=True, slots=True)
class Table:
    """Rows of cells under columns; a list of formulas with annotations is a table without titles.

    ``folds``: where space is short it may be set in parts below each other, the first column in each.
    """

    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]
    caption: Inline = ()
    folds: bool = False


@dataclass(frozen=True, slots=True)
class Listing:
    """Items in a row below each other, numbered where their order matters."""

    items: tuple[Inline, ...]
    numbered: bool = False


@dataclass(frozen=True, slots=True)
class VerdictLine:
    """One verdict in plain words."""

    kind: Kind
    content: Inline


@dataclass(frozen=True, slots=True)
class Note:
    """A remark, or a warning the reader must not miss."""

    kind: Literal["note", "warning"]
    content: Inline


@dataclass(frozen=True, slots=True)
class Details:
    """Blocks that most readers can do without."""

    blocks: tuple[Block, ...]


Block: TypeAlias = Heading | Paragraph | Table | Listing | VerdictLine | Note | Details


@dataclass(frozen=True, slots=True)
class Document:
    """Blocks in reading order."""

    blocks: tuple[Block, ...]

    def flat(self, *, details: bool) -> Document:
        """Return the document with every ``Details`` opened, or left out."""
        return Document(tuple(_flatten(self.blocks, details=details)))


def _flatten(blocks: tuple[Block, ...], *, details: bool) -> list[Block]:
    flat: list[Block] = []
    for block in blocks:
        if not isinstance(block, Details):
            flat.append(block)
        elif details:
            flat += _flatten(block.blocks, details=details)
    return flat


def line(*content: Text | Math) -> Cell:
    """Return a cell of one line."""
    return (content,)


def plain(text: str) -> Inline:
    """Return running text without emphasis."""
    return (Text(text),)
