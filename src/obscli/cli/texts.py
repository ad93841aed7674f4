"""Values given on the command line taken apart: ``name=value`` pairs and comma-separated names."""

from __future__ import annotations

from collections.abc import Sequence

from obscli.cli.errors import CommandError


def pairs(option: str, given: Sequence[str] | None) -> dict[str, str]:
    """Return {name: value}; each name at most once."""
    found: dict[str, str] = {}
    for text in given or ():
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            raise CommandError(f"{option} {text}: expected NAME=VALUE")
        if name in found:
            raise CommandError(f"{option}: {name} is given twice")
        found[name] = value
    return found


def names(given: Sequence[str] | None) -> tuple[str, ...]:
    """Return the names in one or more comma-separated lists."""
    return tuple(name.strip() for text in given or () for name in text.split(",") if name.strip())
