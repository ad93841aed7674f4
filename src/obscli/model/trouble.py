"""What is wrong, while it is being found: one trouble stops one expression, all are reported together."""

from __future__ import annotations

import difflib
import unicodedata
from collections.abc import Iterable, Iterator

from obscli.core.place import ModelError, Problem


LONGEST_SHOWN = 60
MOST_PROBLEMS = 200


class Trouble(Exception):  # noqa: N818
    """One problem with its place; stops the evaluation of the expression it stands in."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        super().__init__(problem.message)


class Silence(Exception):  # noqa: N818
    """A value needs another one that is already reported: nothing more to say."""


class Incomplete(Silence):
    """A value needs a name that only the stages define."""


class Problems:
    """All problems of a reading, each once, in the order found."""

    def __init__(self) -> None:
        self._found: dict[tuple[object, ...], Problem] = {}

    def add(self, problem: Problem) -> None:
        """Keep the problem, unless the same is already said of the same place."""
        self._found.setdefault((problem.place, problem.message), problem)
        if len(self._found) >= MOST_PROBLEMS:
            last = Problem(problem.place, "", f"{MOST_PROBLEMS} problems found; reading stops here")
            raise ModelError([*self._found.values(), last])

    def __iter__(self) -> Iterator[Problem]:
        return iter(self._found.values())

    def __len__(self) -> int:
        return len(self._found)

    def raise_any(self) -> None:
        """Raise the model error if anything was found."""
        if self._found:
            raise ModelError(self._found.values())


def shown(text: str, longest: int = LONGEST_SHOWN) -> str:
    """Return the text fit for a message: one line, nothing a terminal would obey, not too long."""
    if len(text) > longest:
        text = text[: longest - 1] + "…"
    return "".join(c if is_printable(c) else c.encode("unicode_escape").decode("ascii") for c in text)


def is_printable(character: str) -> bool:
    """Whether the character is harmless in a terminal: no control, direction or surrogate character."""
    return character.isprintable() and unicodedata.category(character) not in {"Cf", "Cc", "Cs", "Co", "Cn"}


def nearest(name: str, known: Iterable[str]) -> str:
    """Return ``did you mean 'x'?`` for the nearest known name, or nothing.

    Letters in the wrong case come first, then the closest spelling.
    """
    if len(name) > LONGEST_SHOWN:
        return ""
    letters, spare = set(name.casefold()), max(2, len(name) // 2)
    names = sorted({k for k in known if abs(len(k) - len(name)) <= spare and letters & set(k.casefold())})
    folded = [k for k in names if k.casefold() == name.casefold()]
    close = folded or difflib.get_close_matches(name, names[:500], n=1, cutoff=0.6)
    return f"; did you mean '{shown(close[0])}'?" if close else ""
