"""Findings as JSON values: the stable interface; keys may be added, none renamed or dropped."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol

from obscli.core.number import json_number
from obscli.core.version import SCHEMA, VERSION
from obscli.exact.finding import (
    Analysis,
    Certificate,
    Combination,
    CriticalValue,
    NearMiss,
    Neglect,
    Undecided,
)
from obscli.exact.lift_finding import Stationary
from obscli.model.notation import covector_latex, covector_text
from obscli.model.system import Covector, Model, System
from obscli.pipelines.certificate_data import certificate_to_data, covector_to_data
from obscli.pipelines.certified_data import certified_data
from obscli.pipelines.latex_names import latex_names
from obscli.pipelines.numeric_data import basis_data, numeric_data, verification_data
from obscli.pipelines.request import Changes
from obscli.pipelines.stage_result import StageResult
from obscli.pipelines.structure_data import structure_data


class OfStage(Protocol):
    """Whatever is about one stage of a model."""

    @property
    def model(self) -> Model:
        """The model."""

    @property
    def system(self) -> System:
        """The stage."""


def report_data(results: Iterable[StageResult], changes: Changes) -> dict[str, object]:
    """Return ``{schema, obscli, changes, results}``, one entry of ``results`` a stage."""
    return {
        "schema": SCHEMA,
        "obscli": VERSION,
        "changes": changes.data(),
        "results": [_stage_data(result) for result in results],
    }


def model_data(result: OfStage) -> dict[str, object]:
    """Return which stage of which model a result is about."""
    return {"name": result.model.name, "file": str(result.model.file), "stage": result.system.stage}


def _stage_data(result: StageResult) -> dict[str, object]:
    system = result.system
    finding = result.finding
    return {
        "model": model_data(result),
        "dual": system.dual,
        "discrete": system.discrete,
        "frozen": result.frozen and result.frozen.data(),
        "n": system.n,
        "m": system.m,
        "states": list(system.state_names),
        "analytic": _exact_data(finding),
        "structure": structure_data(result),
        "numeric": numeric_data(result.numeric),
        "numeric_basis": basis_data(result.basis),
        "verification": verification_data(result.verification),
        **certified_data(result.certified),
        "stationary": stationary_witness(result.stationary),
    }


def stationary_witness(found: Stationary | None) -> dict[str, object] | None:
    """Return the size of a stationary system with the same outputs, and whether it agrees; else None."""
    if found is None:
        return None
    return {"smallest": found.smallest.n, "rank": found.rank, "agrees": found.agrees}


def _exact_data(finding: Analysis | Undecided | None) -> dict[str, object] | None:
    """Return the exact finding; None where it was not asked for."""
    match finding:
        case None:
            return None
        case Undecided():
            return _undecided_data(finding)
        case Analysis():
            return _analysis_data(finding)


def _analysis_data(finding: Analysis) -> dict[str, object]:
    system = finding.system
    return {
        "rank": finding.rank,
        "order": finding.order,
        "at_values": {
            "rank": finding.at_values.rank,
            "because": list(finding.at_values.because),
            "reason": finding.at_values.reason,
            "certificate": _certificate(finding.at_values.certificate),
            "nearly": [_near_miss(one) for one in finding.at_values.nearly],
        },
        "frozen_rank": finding.frozen_rank,
        "combinations": [_combination(one, system) for one in finding.combinations],
        "unobservable": [{"coefficients": covector_to_data(one)} for one in finding.unobservable],
        "states": dict(finding.states),
        "groups": [list(group) for group in finding.groups],
        "quantities": {one.name: one.verdict for one in finding.quantities},
        "quantity_details": {
            one.name: {"coefficients": covector_to_data(one.coefficients), "group": list(one.group)}
            for one in finding.quantities
        },
        "certificate": _certificate(finding.certificate),
        **_critical_data(finding),
        "neglect": [_neglect(one, system) for one in finding.neglect],
        "varying": list(finding.varying),
        "undecided": list(finding.undecided),
        "notes": list(finding.notes),
        "advice": list(finding.advice),
    }


def _undecided_data(finding: Undecided) -> dict[str, object]:
    """Return the keys of a finding, empty, with the reason why."""
    return {
        "rank": None,
        "order": None,
        "at_values": {
            "rank": None,
            "because": [],
            "reason": finding.reason,
            "certificate": None,
            "nearly": [],
        },
        "frozen_rank": None,
        "combinations": [],
        "unobservable": [],
        "states": {},
        "groups": [],
        "quantities": {},
        "quantity_details": {},
        "certificate": None,
        "critical": [],
        "critical_complete": False,
        "critical_apart": [],
        "not_searched": [],
        "instants": [],
        "neglect": [],
        "varying": [],
        "undecided": [finding.reason],
        "notes": [],
        "advice": [],
    }


def _combination(one: Combination, system: System) -> dict[str, object]:
    return {
        **combination_data(one.coefficients, system),
        "constant": one.constant,
        "first_from": {"output": one.output, "order": one.order},
    }


def combination_data(covector: Covector, system: System) -> dict[str, object]:
    """Return a combination as expression, LaTeX and coefficients."""
    return {
        "expression": covector_text(covector, system.state_names),
        "latex": covector_latex(covector, system.state_names, latex_names(system)),
        "coefficients": covector_to_data(covector),
    }


def _certificate(certificate: Certificate | None) -> dict[str, object] | None:
    return None if certificate is None else certificate_to_data(certificate)


def _near_miss(one: NearMiss) -> dict[str, object]:
    """Return a condition that is nearly met; ``relative_to``: the value, a ``unit``, or a ``rate``."""
    return {
        "condition": one.condition,
        "rank": one.rank,
        "distance": json_number(one.distance),
        "relative_to": one.measure,
    }


def _critical_data(finding: Analysis) -> dict[str, object]:
    """Return ``critical`` (confirmed), and apart from it what is excluded, undefined or undecided."""
    search = finding.critical
    values = search.values if search else ()
    return {
        "critical": [_critical(one, finding.system) for one in values if one.kind == "confirmed"],
        "critical_complete": search.complete if search else False,
        "critical_apart": [_critical(one, finding.system) for one in values if one.kind != "confirmed"],
        "not_searched": list(search.not_searched) if search else ["critical values: not asked for"],
        "instants": list(search.instants) if search else [],
    }


def _critical(one: CriticalValue, system: System) -> dict[str, object]:
    return {
        "condition": one.condition,
        "kind": one.kind,
        "rank": one.rank,
        "lost": [combination_data(covector, system) for covector in one.lost],
        "reason": one.reason,
        "functions": one.functions,
    }


def _neglect(one: Neglect, system: System) -> dict[str, object]:
    return {
        "substitution": one.substitution,
        "rank_before": one.rank_before,
        "rank_after": one.rank_after,
        "lost": [combination_data(covector, system) for covector in one.lost],
        "gained": [combination_data(covector, system) for covector in one.gained],
    }
