"""Explanations as JSON values."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict

from obscli.core.number import json_number
from obscli.core.version import SCHEMA, VERSION
from obscli.exact.finding import Undecided
from obscli.exact.why import Explanation
from obscli.numeric.finding import Knowledge, NotComputed
from obscli.pipelines.analysis_data import combination_data, model_data
from obscli.pipelines.certificate_data import covector_to_data
from obscli.pipelines.request import Changes
from obscli.pipelines.structure_data import mode_data
from obscli.pipelines.why_result import WhyResult


def why_data(results: Iterable[WhyResult], changes: Changes) -> dict[str, object]:
    """Return ``{schema, obscli, changes, results}``, one entry of ``results`` a target in a stage."""
    return {
        "schema": SCHEMA,
        "obscli": VERSION,
        "changes": changes.data(),
        "results": [_result(result) for result in results],
    }


def _result(result: WhyResult) -> dict[str, object]:
    return {
        "model": model_data(result),
        "why": {
            "target": result.target.name,
            "coefficients": covector_to_data(result.target.coefficients),
            **_finding(result.finding),
            "at_values": _at_values(result.finding),
            **_known(result.known),
        },
    }


def _at_values(finding: Explanation | Undecided) -> dict[str, object] | None:
    """Return the same at the file's values; None where the rank there is the generic one."""
    if isinstance(finding, Undecided) or finding.at_values is None:
        return None
    there = finding.at_values
    return {"because": list(there.because) if isinstance(there, Explanation) else [], **_finding(there)}


def _finding(finding: Explanation | Undecided) -> dict[str, object]:
    if isinstance(finding, Undecided):
        return {
            "verdict": "undecided", "reason": finding.reason, "rank": None, "group": [], "directions": [],
            "modes": [], "seen_by": None, "combinations": [], "correction": [], "conditions": [],
        }  # fmt: skip
    system = finding.system
    return {
        "verdict": finding.verdict,
        "reason": "",
        "rank": finding.rank,
        "group": list(finding.group),
        "directions": [covector_to_data(one) for one in finding.directions],
        "modes": [mode_data(one) for one in finding.modes],
        "seen_by": None if finding.seen_by is None else _origin(*finding.seen_by),
        "combinations": [
            {**combination_data(one.coefficients, system), "seen_by": _origin(one.output, one.order)}
            for one in finding.combinations
        ],
        "correction": [combination_data(one, system) for one in finding.corrections],
        "conditions": [asdict(one) for one in finding.trials],
    }


def _origin(output: str, order: int) -> dict[str, object]:
    return {"output": output, "order": order}


def _known(known: Knowledge | NotComputed | None) -> dict[str, object]:
    if not isinstance(known, Knowledge):
        reason = known.reason if isinstance(known, NotComputed) else ""
        return {"deviation": None, "partners": [], "floor": None, "without": {}, "no_deviation": reason}
    return {
        "deviation": {
            "start": json_number(known.before),
            "end": json_number(known.after),
            "interval": {"start": known.start, "stop": known.stop},
            "assumed": list(known.assumed),
        },
        "partners": [{"state": name, "correlation": rho} for name, rho in known.partners],
        "floor": known.floor,
        "without": {name: json_number(value) for name, value in known.without.items()},
        "no_deviation": "",
    }
