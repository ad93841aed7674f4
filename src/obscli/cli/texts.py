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


def assignments(option: str, given: Sequence[str] | None) -> dict[str, str]:
    """Return {name: value} of comma-separated lists of ``name=value``; commas within brackets are values'."""
    return pairs(option, [one for text in given or () for one in _split(text)])


def _split(text: str) -> list[str]:
    found, depth = [""], 0
    for letter in text:
        depth += (letter in "([") - (letter in ")]")
        if letter == "," and not depth:
            found.append("")
        else:
            found[-1] += letter
    return [one for one in found if one.strip()]


def names(given: Sequence[str] | None) -> tuple[str, ...]:
    """Return the names in one or more comma-separated lists."""
    return tuple(name.strip() for text in given or () for name in text.split(",") if name.strip())
