"""A plan as JSON values, in the frame that every command's JSON has."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Final

from obscli.core.number import json_number
from obscli.core.version import SCHEMA, VERSION
from obscli.exact.finding import Analysis
from obscli.pipelines.calibration_data import accuracy_data, required_data
from obscli.pipelines.certificate_data import covector_to_data
from obscli.pipelines.numeric_data import verification_data
from obscli.pipelines.plan_result import PlanResult
from obscli.pipelines.request import Changes


if TYPE_CHECKING:
    from obscli.experiment.ranking import RankedSet

#: Sets written at the most; their number is always there.
MOST_SETS: Final = 2000


def plan_data(results: Iterable[PlanResult], changes: Changes) -> dict[str, object]:
    """Return ``{schema, obscli, changes, results}``, one entry of ``results`` a plan."""
    return {
        "schema": SCHEMA,
        "obscli": VERSION,
        "changes": changes.data(),
        "results": [_result(result) for result in results],
    }


def _result(result: PlanResult) -> dict[str, object]:
    plan, found = result.plan, result.plan.found
    finding = plan.there.finding
    directions = finding.unobservable if isinstance(finding, Analysis) else ()
    return {
        "model": {"name": result.model.name, "file": str(result.model.file), "stage": None},
        "plan": {
            "constants": list(plan.shared),
            "fresh": list(plan.fresh),
            "candidates": [
                {
                    "name": one.run.name,
                    "stage": one.run.stage,
                    "duration": json_number(duration),
                    "rows": len(one.rows),
                    "states": {state: one.verdict(state) for state in plan.shared},
                }
                for one, duration in zip(plan.stack.runs, plan.durations, strict=True)
            ],
            "forbidden": list(plan.left_out),
            "forbidden_sets": [list(one) for one in plan.not_together],
            "setup_time": json_number(plan.setup_time),
            "rank": found.rank,
            "rank_at_values": result.rank_at_values,
            "rank_of_all": finding.rank if isinstance(finding, Analysis) else None,
            "columns": len(plan.shared),
            "size": found.size,
            "exhaustive": found.exhaustive,
            "guarantee": json_number(found.guarantee),
            "count": len(found.sets),
            "sets": [_set(result, one) for one in plan.ranked[:MOST_SETS]],
            "recommended": None if plan.chosen is None else _set(result, plan.chosen),
            "undetermined_directions": [{"coefficients": covector_to_data(one)} for one in directions],
            "suggestions": [{"words": one.words, "rank": one.rank} for one in plan.suggestions],
            "tried": list(plan.tried),
            "accuracy": None if result.accuracy is None else accuracy_data(result.accuracy),
            "no_accuracy": plan.no_accuracy,
            "require": []
            if result.accuracy is None
            else [required_data(one) for one in result.accuracy.required],
        },
        "verification": verification_data(result.verification),
    }


def _set(result: PlanResult, one: RankedSet) -> dict[str, object]:
    shortest = one.shortest
    return {
        "runs": [result.plan.runs[k].name for k in one.runs],
        "duration": json_number(one.duration),
        "margin": json_number(one.margin),
        "met": one.is_met,
        "shortest": None if shortest is None else [json_number(value) for value in shortest.durations],
        "shortest_duration": None if shortest is None else json_number(one.needed),
    }
