"""Where in a file a value stands, and what can be wrong with it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, order=True)
class Place:
    """A position in a text: file name as the user gave it, line and column counted from 1, width ≥ 1."""

    file: str
    line: int
    column: int
    width: int = 1

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}"


@dataclass(frozen=True, slots=True)
class Problem:
    """One thing wrong in a file: where, in which key, what was found and expected, and a remedy.

    ``source`` is the line (or, of a very long line, the part of it) around the place, ``caret`` the
    column in that excerpt (0: the column of the place).
    """

    place: Place
    path: str
    message: str
    hint: str = ""
    source: str = ""
    caret: int = 0

    def __str__(self) -> str:
        head = f"{self.place}: {self.path + ': ' if self.path else ''}{self.message}"
        parts = [head]
        if self.source:
            caret = " " * ((self.caret or self.place.column) - 1) + "^" * max(1, self.place.width)
            parts += [f"    {self.source}", f"    {caret}"]
        if self.hint:
            parts.append(f"  hint: {self.hint}")
        return "\n".join(parts)


class ModelError(Exception):
    """A model file that cannot be read; carries every problem found, in the order of the file."""

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems = tuple(sorted(problems, key=lambda problem: (problem.place, problem.message)))
        super().__init__("\n".join(str(problem) for problem in self.problems))
