"""The work of ``obscli transform``: the systems of a model in new variables, each as a model of its own."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from obscli.core.document import Document
from obscli.core.figure import Figure
from obscli.model.discrete import require_continuous
from obscli.model.system import Model, System
from obscli.pipelines.describe.transform import transform_document
from obscli.pipelines.reading import chosen_systems
from obscli.pipelines.request import Changes, Progress, RequestError, TransformRequest, silent
from obscli.pipelines.transform_data import transform_data
from obscli.pipelines.transform_result import StationaryForm, Transformed, TransformResult
from obscli.pipelines.transforming import Transformation


@dataclass(frozen=True, slots=True, eq=False)
class TransformReport:
    """What each stage of one model was transformed to, and the changes under which it was read."""

    results: tuple[TransformResult, ...]
    changes: Changes

    @property
    def text(self) -> str:
        """The model file made, where there is one stage and something came of it; else empty."""
        found = [result.finding for result in self.results]
        return found[0].text if len(found) == 1 and isinstance(found[0], Transformed | StationaryForm) else ""

    @property
    def failed(self) -> int:
        """How many checks failed."""
        return sum(result.failed for result in self.results)

    @property
    def undecided(self) -> int:
        """How many things stayed undecided."""
        return sum(result.undecided for result in self.results)

    def document(self) -> Document:
        """Return the report for a reader."""
        return transform_document(self.results)

    def figures(self) -> Iterable[Figure]:
        """Return no figures: there is nothing to draw."""
        return ()

    def data(self) -> Mapping[str, object]:
        """Return the report for a program."""
        return transform_data(self.results, self.changes)


def transform(
    model: Model,
    request: TransformRequest = TransformRequest(),  # noqa: B008 - frozen and empty
    changes: Changes = Changes(),  # noqa: B008 - frozen and empty
    progress: Progress = silent,
) -> TransformReport:
    """Transform the chosen stages of a model.

    Parameters
    ----------
    model : the model as it is to be transformed, all changes made
    request : to what, which stages, in which variables
    changes : the changes made, for the record
    progress : told what is being done

    Raises
    ------
    RequestError
        where one stage is wanted and there are several
    """
    systems = chosen_systems(model, request.stages)
    if request.one and len(systems) > 1:
        raise RequestError(_one_of(systems))
    results = []
    for system in systems:
        if request.to == "stationary":
            require_continuous(system, "--to stationary")
        progress(f"{system.stage or model.name}: {request.to}")
        results.append(Transformation(model, system, request, changes).result())
    return TransformReport(tuple(results), changes)


def _one_of(systems: Iterable[System]) -> str:
    known = ", ".join("the base" if system.stage is None else system.stage for system in systems)
    return f"one model is written at a time; choose the stage with --stage NAME: {known}"
