"""How far a long computation is: text for whoever watches; an interrupt keeps what is done."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeAlias, TypeVar


#: Told what is being done; may be called often.
Progress: TypeAlias = Callable[[str], None]

_Found = TypeVar("_Found")


def silent(_: str) -> None:
    """Progress that nobody watches."""


def until_interrupted(steps: Iterable[_Found]) -> tuple[list[_Found], bool]:
    """Return what the steps yield, and whether all did: an interrupt keeps those before it."""
    found: list[_Found] = []
    try:
        found.extend(steps)
    except KeyboardInterrupt:
        return found, False
    return found, True
