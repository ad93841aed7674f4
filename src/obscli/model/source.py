"""A text with a name: its lines, its excerpts for carets, and what makes it unreadable."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from obscli.core.place import ModelError, Place, Problem
from obscli.model.trouble import shown


LARGEST_FILE: Final = 5_000_000
LONGEST_EXCERPT: Final = 110
_BREAK: Final = re.compile(r"\r\n|\r|\n")
#: Characters no model needs and a terminal or an editor might obey: controls, directions, line separators.
HARMFUL: Final = re.compile(
    "[\\x00-\\x08\\x0b\\x0c\\x0e-\\x1f\\x7f-\\x9f\\u200b-\\u200f\\u2028-\\u202e\\u2060-\\u206f\\ufeff\\ufff9-\\uffff"
    "\\ud800-\\udfff]"
)


@dataclass(frozen=True, slots=True, eq=False)
class Source:
    """The text of a file (or of a command-line option) and the name it goes by in messages."""

    file: str
    text: str
    _lines: list[str] = field(default_factory=list)

    def line(self, number: int) -> str:
        """Return the line (from 1), without its end; empty beyond the last."""
        if not self._lines:
            self._lines.extend(_BREAK.split(self.text))
        return self._lines[number - 1] if number <= len(self._lines) else ""

    def problem(self, line: int, column: int, width: int, path: str, message: str, hint: str = "") -> Problem:
        """Return the problem at this place, with the excerpt of the line that contains it."""
        excerpt, caret = self._excerpt(line, column)
        width = max(1, min(width, len(excerpt) - caret + 1))
        place = Place(shown(self.file, 200), line, column, width)
        return Problem(place, shown(path, 120), message, hint, excerpt, caret)

    def _excerpt(self, line: int, column: int) -> tuple[str, int]:
        text = self.line(line)
        start = 0 if len(text) <= LONGEST_EXCERPT else max(0, column - 1 - LONGEST_EXCERPT // 2)
        part = text[start : start + LONGEST_EXCERPT]
        return "".join(_one_cell(c) for c in part).rstrip(), column - start


def _one_cell(character: str) -> str:
    """Return the character, or a space or question mark as wide where it must not reach a terminal."""
    if character == "\t":
        return " "
    return "?" if HARMFUL.match(character) else character


def read_source(path: str | Path) -> Source:
    """Read a file as UTF-8 text; everything that can go wrong is a ``ModelError``."""
    file = str(path)
    try:
        with Path(path).open("rb") as stream:
            data = stream.read(LARGEST_FILE + 1)
    except IsADirectoryError:
        raise _unreadable(file, "this is a directory, not a model file") from None
    except FileNotFoundError:
        raise _unreadable(file, "there is no such file") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "the name is not that of a file"
        raise _unreadable(file, f"cannot be read: {reason}") from None
    if len(data) > LARGEST_FILE:
        raise _unreadable(file, "the file is larger than 5 MB; a model is a few kilobytes of text")
    return decode(data, file)


def decode(data: bytes, file: str) -> Source:
    """Return the bytes as a checked source."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = data[: error.start]
        line = before.count(b"\n") + 1
        column = len(before[before.rfind(b"\n") + 1 :].decode("utf-8", "replace")) + 1
        message = f"byte 0x{data[error.start]:02x} is not UTF-8 text"
        hint = "save the file as UTF-8; a model file is text, not a spreadsheet or a binary"
        raise ModelError([Problem(Place(shown(file, 200), line, column), "", message, hint)]) from None
    return checked(text, file)


def checked(text: str, file: str) -> Source:
    """Return the text as a source, refusing what a terminal might obey."""
    source = Source(file, text.removeprefix("\ufeff"))
    if len(text) > LARGEST_FILE:
        raise _unreadable(file, "the text is longer than 5 MB; a model is a few kilobytes of text")
    harmful = HARMFUL.search(source.text)
    if harmful:
        before = _BREAK.split(source.text[: harmful.start()])
        message = f"character U+{ord(harmful[0]):04X} is not allowed in a model file"
        hint = "control characters, escape codes and invisible marks have no place in a model; delete it"
        problem = source.problem(len(before), len(before[-1]) + 1, 1, "", message, hint)
        raise ModelError([problem])
    return source


def _unreadable(file: str, message: str) -> ModelError:
    return ModelError([Problem(Place(shown(file, 200), 1, 1), "", message)])
