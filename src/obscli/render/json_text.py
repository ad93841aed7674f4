"""JSON: the report for programs, the stable interface."""

from __future__ import annotations

from typing import Final

from obscli.core.report import Report
from obscli.core.visible import visible
from obscli.render.format import Format, Surface


def render(report: Report, surface: Surface) -> str:
    """Return the data of the report, everything in it whatever the surface; invisible characters escaped."""
    import json  # noqa: PLC0415 - only this format pays for it

    del surface
    text = json.dumps(report.data(), indent=2, ensure_ascii=False, allow_nan=False)
    hidden = {c for c in set(text) if c != "\n" and visible(c) != c}
    return text.translate({ord(c): _escaped(c) for c in hidden}) + "\n"


def _escaped(character: str) -> str:
    units = character.encode("utf-16-be", "surrogatepass")
    return "".join(rf"\u{units[k]:02x}{units[k + 1]:02x}" for k in range(0, len(units), 2))


JSON: Final = Format("json", render)
