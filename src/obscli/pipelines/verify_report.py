"""What ``obscli verify`` hands to a renderer."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from obscli.core.document import Document
from obscli.core.figure import Figure
from obscli.pipelines.describe.checks import check_document
from obscli.pipelines.describe.figures import check_figures
from obscli.pipelines.stage_result import StageChecks
from obscli.pipelines.verify_data import verify_data


@dataclass(frozen=True, slots=True, eq=False)
class VerifyReport:
    """Every check of every stage, in the order they were made."""

    results: tuple[StageChecks, ...]

    @property
    def failed(self) -> int:
        """How many checks failed."""
        return self._count("fails")

    @property
    def undecided(self) -> int:
        """How many checks could not be decided."""
        return self._count("undecided")

    def _count(self, verdict: str) -> int:
        return sum(check.verdict == verdict for result in self.results for check in result.checks)

    def document(self) -> Document:
        """Return the report for a reader: a line a check, then the count."""
        return check_document(self.results)

    def figures(self) -> Iterable[Figure]:
        """Return the figures: χ of the analysis and of every claimed basis."""
        return check_figures(self.results)

    def data(self) -> Mapping[str, object]:
        """Return the report for a program."""
        return verify_data(self.results, failed=self.failed, undecided=self.undecided)
