"""Lines in colour, for a terminal; the same lines read as well without."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import groupby
from typing import Final

from obscli.core.document import Role
from obscli.render.line import Line


STYLES: Final[Mapping[Role, str]] = {
    "plain": "",
    "strong": "bold",
    "name": "cyan",
    "faint": "bright_black",
    "good": "green",
    "open": "yellow",
    "bad": "red",
}


def coloured(lines: Iterable[Line]) -> str:
    """Return the lines with the escape codes of this terminal (rich decides which colours it has)."""
    from io import StringIO  # noqa: PLC0415 - rich costs start-up time and is needed on a terminal only

    from rich.console import Console  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    console = Console(file=StringIO(), force_terminal=True, soft_wrap=True, highlight=False, width=10_000)
    with console.capture() as capture:
        for line in lines:
            runs = (
                ("".join(t for t, _ in run), STYLES[role])
                for role, run in groupby(line, lambda piece: piece[1])
            )
            console.print(Text.assemble(*runs), soft_wrap=True)
    return capture.get()
