"""One thing asserted and what came of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NoReturn

from obscli.core.place import Place


@dataclass(frozen=True, slots=True)
class CheckResult:
    """The verdict on one claim, with its grounds; no truth value, since there are three of them.

    ``claim``: what is asserted, in words; ``reason``: why the verdict stands; ``place``: where it is said.
    """

    claim: str
    verdict: Literal["holds", "fails", "undecided"]
    reason: str
    place: Place | None = None

    def __bool__(self) -> NoReturn:
        raise TypeError("a CheckResult holds, fails or is undecided: compare its verdict")
