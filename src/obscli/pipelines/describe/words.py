"""Small matters of wording shared by the sections of a report."""

from __future__ import annotations

from typing import Final, Literal

from obscli.core.document import Inline, Role, Text
from obscli.core.number import short
from obscli.exact.finding import LinearFormVerdict, StateVerdict


#: The verdicts in the order of a report, with the sign each has in every format, and its role.
SIGNS: Final[dict[StateVerdict, tuple[str, Role]]] = {
    "observable": ("●", "good"),
    "coupled": ("◐", "open"),
    "unobservable": ("·", "bad"),
}
#: What only noise of signals shows.
NOT_EXCITED: Final[tuple[str, Role]] = ("○", "open")
ALL_SIGNS: Final[dict[str, tuple[str, Role]]] = {str(key): own for key, own in SIGNS.items()} | {
    "not excited": NOT_EXCITED
}
UNDECIDED: Final[tuple[str, Role]] = ("?", "open")


def sign(verdict: LinearFormVerdict | Literal["not excited"]) -> Text:
    """Return the sign of a verdict."""
    if verdict == "not excited":
        return Text(*NOT_EXCITED)
    return Text(*(UNDECIDED if verdict == "undecided" else SIGNS[verdict]))


def names(items: tuple[str, ...]) -> Inline:
    """Return names of states, outputs or parameters one after the other."""
    content: list[Text] = []
    for item in items:
        content += [Text(" "), Text(item, "name")]
    return tuple(content[1:])


def ratio(value: float) -> str:
    """Return a margin: 1.00 says that it is just met."""
    return f"{value:.2f}" if 0.1 <= value < 100 else short(value, 3)


def minutes(seconds: float) -> str:
    """Return a time as minutes, where the unit of time is the second."""
    value = seconds / 60
    return str(round(value)) if value >= 100 else short(value, 3)
