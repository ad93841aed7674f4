"""What every command hands to a renderer."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Protocol

from obscli.core.document import Document
from obscli.core.figure import Figure


class Report(Protocol):
    """The outcome of one command: counted verdicts, and the ways to tell it, each made when asked for."""

    @property
    def failed(self) -> int:
        """How many checks failed."""

    @property
    def undecided(self) -> int:
        """How many questions stayed undecided."""

    def document(self) -> Document:
        """Return the report for a reader."""

    def figures(self) -> Iterable[Figure]:
        """Return the figures of the report."""

    def data(self) -> Mapping[str, object]:
        """Return the report for a program: JSON values in the frame ``{schema, obscli, results, …}``."""
