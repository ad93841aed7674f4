"""What ``obscli simulate`` hands to a renderer; importing it costs no floating-point library."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from obscli.core.document import Document
from obscli.core.figure import Figure
from obscli.numeric.finding import NotComputed
from obscli.pipelines.request import Changes
from obscli.pipelines.simulate_columns import history_columns
from obscli.pipelines.simulate_data import history_data, simulate_data
from obscli.pipelines.simulate_result import SimulateResult


@dataclass(frozen=True, slots=True, eq=False)
class SimulateReport:
    """What was simulated in every stage; ``interrupted``: only what was done until then."""

    results: tuple[SimulateResult, ...]
    changes: Changes
    interrupted: bool = False

    @property
    def failed(self) -> int:
        """How many requirements are not met."""
        return sum(result.failed for result in self.results)

    @property
    def undecided(self) -> int:
        """How many stages lack what a simulation needs."""
        return sum(isinstance(result.found, NotComputed) for result in self.results)

    @property
    def simulated(self) -> int:
        """How many stages were simulated."""
        return len(self.results) - self.undecided

    def document(self) -> Document:
        """Return the report for a reader."""
        from obscli.pipelines.describe.simulate import simulate_document  # noqa: PLC0415 - needs scipy

        return simulate_document(self.results)

    def figures(self) -> Iterable[Figure]:
        """Return the figures: deviations against time, consistency, what a mismatched filter claims."""
        from obscli.pipelines.describe.simulate_figures import simulate_figures  # noqa: PLC0415 - needs numpy

        return simulate_figures(self.results)

    def data(self) -> Mapping[str, object]:
        """Return the report for a program."""
        return simulate_data(self.results, self.changes)

    def history_data(self) -> Mapping[str, object]:
        """Return the histories alone, as JSON values."""
        return history_data(self.results)

    def history_columns(self) -> Mapping[str, list[object]]:
        """Return the histories as columns of one table, all of the same length."""
        return history_columns(self.results)
