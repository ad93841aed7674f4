"""The YAML file as a tree of places: scalars stay text, nothing is constructed, nothing recurses.

Built from the event stream of ``yaml.parse``: depth, size, tags, anchors and merge keys are judged
while the events arrive, so a bomb is refused before it unfolds.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from obscli.core.place import Place, Problem
from obscli.model.source import Source


@dataclass(frozen=True, slots=True, eq=False)
class Scalar:
    """A piece of text; ``raw`` is as it stands in the file, quotes and line breaks included."""

    source: Source
    line: int
    column: int
    text: str
    raw: str
    style: str = ""

    @property
    def is_null(self) -> bool:
        """Whether nothing is written, or YAML's word for it."""
        return not self.style and self.text in {"", "~", "null"}

    def position(self, offset: int) -> tuple[int, int]:
        """Return line and column of a character of the text."""
        line, column = self.line, self.column
        for character in self.raw[: self._raw_offset(offset)].replace("\r\n", "\n").replace("\r", "\n"):
            line, column = (line + 1, 1) if character == "\n" else (line, column + 1)
        return line, column

    def _raw_offset(self, offset: int) -> int:
        """Follow the text through the raw form, which has more blanks, quotes and a block's header."""
        if self.style == '"' and "\\" in self.raw:
            return 1
        at = self.raw.find("\n") + 1 if self.style in {"|", ">"} else len(self.style)
        for character in self.text[:offset]:
            if not character.isspace():
                at = self.raw.find(character, at) + 1 or at
        target = self.text[offset : offset + 1]
        if target and not target.isspace():
            return max(at, self.raw.find(target, at))
        return at

    def problem(
        self, path: str, message: str, hint: str = "", *, offset: int = 0, width: int | None = None
    ) -> Problem:
        """Return a problem at this scalar, or at a part of it."""
        line, column = self.position(offset)
        return self.source.problem(line, column, width or len(self.text) or 1, path, message, hint)

    @property
    def place(self) -> Place:
        """Where the text begins."""
        line, column = self.position(0)
        return Place(self.source.file, line, column, max(1, len(self.text)))


@dataclass(frozen=True, slots=True, eq=False)
class Sequence:
    """A list of nodes."""

    source: Source
    line: int
    column: int
    items: tuple[Node, ...]

    def problem(self, path: str, message: str, hint: str = "") -> Problem:
        """Return a problem at the beginning of the list."""
        return self.source.problem(self.line, self.column, 1, path, message, hint)

    @property
    def place(self) -> Place:
        """Where the list begins."""
        return Place(self.source.file, self.line, self.column)


@dataclass(frozen=True, slots=True, eq=False)
class Mapping:
    """A list of keys (text, each once) with nodes."""

    source: Source
    line: int
    column: int
    entries: tuple[tuple[Scalar, Node], ...]

    def problem(self, path: str, message: str, hint: str = "") -> Problem:
        """Return a problem at the beginning of the mapping."""
        return self.source.problem(self.line, self.column, 1, path, message, hint)

    @property
    def place(self) -> Place:
        """Where the mapping begins."""
        return Place(self.source.file, self.line, self.column)

    def get(self, key: str) -> Node | None:
        """Return the value of a key, or None."""
        return next((value for name, value in self.entries if name.text == key), None)


@dataclass(frozen=True, slots=True, eq=False)
class Broken:
    """A node already reported as unreadable; whoever meets it stays silent."""

    source: Source
    line: int
    column: int

    def problem(self, path: str, message: str, hint: str = "") -> Problem:
        """Return a problem at the beginning of the node."""
        return self.source.problem(self.line, self.column, 1, path, message, hint)

    @property
    def place(self) -> Place:
        """Where the node begins."""
        return Place(self.source.file, self.line, self.column)


Node: TypeAlias = Scalar | Sequence | Mapping | Broken


def kind(node: Node) -> str:
    """Return what the node is, in words."""
    match node:
        case Scalar():
            return "nothing" if node.is_null else "a text"
        case Sequence():
            return "a list"
    return "a mapping"
