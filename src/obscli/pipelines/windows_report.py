"""What ``obscli measures --window`` hands to a renderer; importing it costs no floating-point library."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from obscli.core.document import Document
from obscli.core.figure import Figure
from obscli.pipelines.request import Changes


if TYPE_CHECKING:
    from obscli.pipelines.windows_result import WindowsResult


@dataclass(frozen=True, slots=True, eq=False)
class WindowsReport:
    """The windows of every stage, and the changes under which the model was read."""

    results: tuple[WindowsResult, ...]
    changes: Changes

    @property
    def failed(self) -> int:
        """Nothing is asked for that could fail."""
        return 0

    @property
    def undecided(self) -> int:
        """How many stages have no windows, or windows whose rank is not decided."""
        from obscli.numeric.finding import NotComputed  # noqa: PLC0415 - floating point

        found = (result.found for result in self.results)
        return sum(isinstance(one, NotComputed) or not bool(one.values.decided.all()) for one in found)

    def document(self) -> Document:
        """Return the tables for a reader."""
        from obscli.pipelines.describe.windows import windows_document  # noqa: PLC0415 - floating point

        return windows_document(self.results)

    def figures(self) -> Iterable[Figure]:
        """Return the figures: values against time."""
        from obscli.pipelines.describe.windows_figures import windows_figures  # noqa: PLC0415

        return windows_figures(self.results)

    def data(self) -> Mapping[str, object]:
        """Return the windows for a program."""
        from obscli.pipelines.windows_data import windows_data  # noqa: PLC0415

        return windows_data(self.results, self.changes)
