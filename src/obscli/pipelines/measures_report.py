"""What ``obscli measures`` hands to a renderer; importing it costs no floating-point library."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from obscli.core.document import Document
from obscli.core.figure import Figure
from obscli.pipelines.request import Changes


if TYPE_CHECKING:
    from obscli.pipelines.measures_result import MeasuresResult


@dataclass(frozen=True, slots=True, eq=False)
class MeasuresReport:
    """The measures of every stage, and the changes under which the model was read."""

    results: tuple[MeasuresResult, ...]
    changes: Changes

    @property
    def failed(self) -> int:
        """How many requirements and thresholds are not met."""
        return sum(result.failed for result in self.results)

    @property
    def undecided(self) -> int:
        """How much could not be measured or judged."""
        return sum(result.undecided for result in self.results)

    def document(self) -> Document:
        """Return the tables for a reader."""
        from obscli.pipelines.describe.measures import measures_document  # noqa: PLC0415 - floating point

        return measures_document(self.results)

    def figures(self) -> Iterable[Figure]:
        """Return the figures: measures against time."""
        from obscli.pipelines.describe.measures_figures import measures_figures  # noqa: PLC0415

        return measures_figures(self.results)

    def data(self) -> Mapping[str, object]:
        """Return the measures for a program."""
        from obscli.pipelines.measures_data import measures_data  # noqa: PLC0415

        return measures_data(self.results, self.changes)
