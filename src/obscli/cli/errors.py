"""Wrong usage found after the command line was parsed."""

from __future__ import annotations


class CommandError(Exception):
    """A request that cannot be carried out as asked; the message says what to change. Exit code 2."""
