"""What ``obscli plan`` hands to a renderer; importing it costs no floating-point library."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from obscli.core.document import Document
from obscli.core.figure import Figure
from obscli.pipelines.describe.orders import orders_document
from obscli.pipelines.describe.plan import plan_document
from obscli.pipelines.describe.plan_figures import plan_figures
from obscli.pipelines.plan_data import plan_data
from obscli.pipelines.plan_result import PlanResult
from obscli.pipelines.plan_segments import SegmentPlan, orders_data
from obscli.pipelines.request import Changes


@dataclass(frozen=True, slots=True, eq=False)
class PlanReport:
    """The plan for one model, and the changes under which it was read."""

    results: tuple[PlanResult, ...]
    changes: Changes
    segments: SegmentPlan | None = None

    @property
    def failed(self) -> int:
        """How many plans are contradicted by the Gramians, or do not meet what is required."""
        return sum(result.failed for result in self.results)

    @property
    def undecided(self) -> int:
        """How many plans stayed unchecked."""
        open_ = self.segments is not None and not self.segments.found.is_complete
        return sum(result.undecided for result in self.results) + open_

    def document(self) -> Document:
        """Return the report for a reader."""
        return plan_document(self.results) if self.segments is None else orders_document(self.segments)

    def figures(self) -> Iterable[Figure]:
        """Return the figures: what each candidate determines, deviations over the plan."""
        return plan_figures(self.results)

    def data(self) -> Mapping[str, object]:
        """Return the report for a program."""
        return {**plan_data(self.results, self.changes), **orders_data(self.segments)}
