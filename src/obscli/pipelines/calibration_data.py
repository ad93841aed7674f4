"""An experiment as JSON values, in the frame that every command's JSON has."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from obscli.core.number import json_number
from obscli.core.version import SCHEMA, VERSION
from obscli.exact.finding import Analysis, CriticalValue, Undecided
from obscli.experiment.special import Special
from obscli.model.system import System
from obscli.pipelines.analysis_data import combination_data
from obscli.pipelines.calibration_result import CalibrationResult, RunResult
from obscli.pipelines.certificate_data import certificate_to_data, covector_to_data
from obscli.pipelines.numeric_data import numeric_data, verification_data
from obscli.pipelines.request import Changes


if TYPE_CHECKING:
    from obscli.experiment.accuracy import Accuracy, Deviation, Required


def calibration_data(results: Iterable[CalibrationResult], changes: Changes) -> dict[str, object]:
    """Return ``{schema, obscli, changes, results}``, one entry of ``results`` an experiment."""
    return {
        "schema": SCHEMA,
        "obscli": VERSION,
        "changes": changes.data(),
        "results": [_result(result) for result in results],
    }


def _result(result: CalibrationResult) -> dict[str, object]:
    system = result.runs[0].run.system
    return {
        "model": {"name": result.model.name, "file": str(result.model.file), "stage": None},
        "n": system.n,
        "states": list(system.state_names),
        "experiment": experiment_data(result),
        "numeric": numeric_data(result.together),
        "verification": verification_data(result.verification),
    }


def experiment_data(result: CalibrationResult) -> dict[str, object]:
    """Return ``{name, runs, constants, fresh, matrix, determined, coupled, undetermined, require, …}``."""
    exact, finding = result.exact, result.exact.stack.finding
    states: Mapping[str, str] = finding.states if isinstance(finding, Analysis) else {}
    adds = exact.stack.adds
    return {
        "name": result.experiment.name,
        "default": result.is_default,
        "constants": list(exact.shared),
        "fresh": list(exact.fresh),
        "own_symbols": [
            {"name": one.name, "parameter": one.of, "value": one.value, "runs": list(one.runs)}
            for one in exact.own
        ],
        "runs": [_run(result, one, len(rows)) for one, rows in zip(result.runs, adds, strict=True)],
        "matrix": {
            "rows": exact.stack.system.m,
            "columns": len(exact.shared),
            "rank": exact.rank,
            "rank_at_values": exact.at_file.rank,
            "because": list(exact.at_file.because),
            "reason": exact.at_file.reason,
        },
        "determined": _with(states, "observable"),
        "coupled": _with(states, "coupled"),
        "undetermined": _with(states, "unobservable"),
        **_together(finding),
        **_special(exact.special, exact.stack.system),
        "after_runs": None if result.after is None else list(result.after),
        "accuracy": None if result.accuracy is None else accuracy_data(result.accuracy),
        "no_accuracy": result.no_accuracy,
        "require": []
        if result.accuracy is None
        else [required_data(one) for one in result.accuracy.required],
    }


def _with(states: Mapping[str, str], verdict: str) -> list[str]:
    return [state for state, own in states.items() if own == verdict]


def _run(result: CalibrationResult, one: RunResult, adds: int) -> dict[str, object]:
    finding, system = one.rows.finding, result.exact.stack.system
    lasts = one.lasts
    return {
        "name": one.run.name,
        "stage": one.run.stage,
        "start": None if lasts is None else lasts[0],
        "stop": None if lasts is None else lasts[1],
        "rank": finding.rank if isinstance(finding, Analysis) else None,
        "rows": len(one.rows.rows),
        "adds": adds,
        "undecided": one.rows.undecided,
        "combinations": [combination_data(row, system) for row in one.rows.rows],
        "states": {state: one.verdict(state) for state in result.exact.shared},
        "numeric": numeric_data(one.numeric),
        "verification": verification_data(one.verification),
    }


def _together(finding: Analysis | Undecided) -> dict[str, object]:
    """Return the combinations that all runs determine, and the directions that none shows."""
    if isinstance(finding, Undecided):
        return {"combinations": [], "directions": [], "quantities": {}, "certificate": None,
                "undecided": [finding.reason]}  # fmt: skip
    return {
        "combinations": [combination_data(one.coefficients, finding.system) for one in finding.combinations],
        "directions": [{"coefficients": covector_to_data(one)} for one in finding.unobservable],
        "quantities": {one.name: one.verdict for one in finding.quantities},
        "certificate": None if finding.certificate is None else certificate_to_data(finding.certificate),
        "undecided": list(finding.undecided),
    }


def _special(special: Special | None, system: System) -> dict[str, object]:
    drops = special.drops if special else ()
    return {
        "critical": [_critical(one, system) for one in drops if one.kind == "confirmed"],
        "critical_complete": special.complete if special else False,
        "critical_apart": [_critical(one, system) for one in drops if one.kind != "confirmed"],
        "not_searched": list(special.not_searched) if special else ["critical values: not asked for"],
    }


def _critical(one: CriticalValue, system: System) -> dict[str, object]:
    return {
        "condition": one.condition,
        "kind": one.kind,
        "rank": one.rank,
        "lost": [combination_data(covector, system) for covector in one.lost],
        "reason": one.reason,
    }


def accuracy_data(found: Accuracy) -> dict[str, object]:
    """Return the deviations of every shared state, in time too."""
    return {
        "states": {one.name: _deviation(one) for one in found.states},
        "history": {
            "t": [json_number(t) for t in found.history.times],
            "ends": [json_number(t) for t in found.history.ends],
            "standard_deviation": {
                one.name: [json_number(value) for value in values]
                for one, values in zip(found.states, found.history.values, strict=True)
            },
        },
        "notes": list(found.notes),
    }


def _deviation(one: Deviation) -> dict[str, object]:
    return {
        "unit": one.unit,
        "before": json_number(one.before),
        "after": json_number(one.after),
        "after_runs": [json_number(value) for value in one.runs],
        "alone": [json_number(value) for value in one.alone],
    }


def required_data(one: Required) -> dict[str, object]:
    """Return one requirement with its margin."""
    return {
        "name": one.name,
        "unit": one.unit,
        "required": json_number(one.required),
        "before": json_number(one.before),
        "after": json_number(one.after),
        "margin": json_number(one.margin),
        "met": one.is_met,
    }
