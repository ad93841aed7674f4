"""Text made safe for a drawing: no character of a file can start a formula."""

from __future__ import annotations

from obscli.core.visible import visible


def in_figure(text: str) -> str:
    """Return text that matplotlib shows as it is: dollars would start a formula."""
    return visible(text).replace("$", r"\$")
