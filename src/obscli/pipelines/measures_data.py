"""Measures as JSON values."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from obscli.core.number import json_number
from obscli.core.version import SCHEMA, VERSION
from obscli.exact.finding import Undecided
from obscli.measures.measure import Direction, Found, SystemValue
from obscli.model.notation import to_text
from obscli.numeric.finding import NotComputed
from obscli.pipelines.analysis_data import model_data
from obscli.pipelines.certificate_data import covector_to_data
from obscli.pipelines.measures_result import Limit, MeasuresResult, Taken
from obscli.pipelines.request import Changes


def measures_data(results: Iterable[MeasuresResult], changes: Changes) -> dict[str, object]:
    """Return ``{schema, obscli, changes, results}``, one entry of ``results`` a stage."""
    return {
        "schema": SCHEMA,
        "obscli": VERSION,
        "changes": changes.data(),
        "results": [_result(result) for result in results],
    }


def _result(result: MeasuresResult) -> dict[str, object]:
    return {"model": model_data(result), "measures": _measures(result)}


def _measures(result: MeasuresResult) -> dict[str, object]:
    taken = result.taken
    if isinstance(taken, Undecided | NotComputed):
        return {"reason": taken.reason, "scaling": result.scaling}
    last, horizon = taken[-1], result.horizon
    assert horizon is not None
    return {
        **_at(last),
        "reason": "",
        "scaling": result.scaling,
        "units": {name: json_number(unit) for name, unit in result.units.items()},
        "interval": {"start": horizon.start, "stop": horizon.stop, "origin": horizon.origin},
        "measures": {
            one.key: {"title": one.title, "better": one.better, "reading": one.reading}
            for one in result.measures
        },
        "options": {one.key: dict(last.subject.options[one.key]) for one in result.measures if one.options},
        "assumed_step": result.assumed_step,
        "sampled_functions": list(result.sampled),
        "limits": [_limit(one) for one in result.limits],
        "reordered": [
            {"measure": one.key, "ranking": list(one.given), "other": list(one.other), "units": one.units}
            for one in result.reordered
        ],
        "times": [_at(one) for one in taken] if len(taken) > 1 else [],
    }


def _at(taken: Taken) -> dict[str, object]:
    """Return all measures at one instant."""
    subject = taken.subject
    found = {key: one for key, one in taken.found.items() if isinstance(one, Found)}
    return {
        "at": subject.at,
        "rank": subject.rank,
        "system": {key: _system(value) for one in found.values() for key, value in one.system.items()},
        "states": _targets(taken, "state"),
        "quantities": _targets(taken, "quantity"),
        "combinations": [
            {
                "expression": target.name,
                "coefficients": covector_to_data(target.coefficients),
                **_values(taken, k),
            }
            for k, target in enumerate(subject.targets)
            if target.kind == "combination"
        ],
        "closed_forms": {
            key: {name: to_text(form) for name, form in one.forms.items()}
            for key, one in found.items()
            if one.forms
        },
        "remarks": {key: list(one.remarks) for key, one in found.items() if one.remarks},
        "not_measured": {key: one.reason for key, one in taken.found.items() if isinstance(one, NotComputed)},
    }


def _targets(taken: Taken, kind: str) -> dict[str, object]:
    return {
        target.name: {"observable": target.observable, **_values(taken, k)}
        for k, target in enumerate(taken.subject.targets)
        if target.kind == kind
    }


def _values(taken: Taken, k: int) -> dict[str, object]:
    """Return the values of one target, null where a measure has none."""
    return {
        key: json_number(found.targets[k])
        for key, found in taken.found.items()
        if isinstance(found, Found) and found.targets
    }


def _system(value: SystemValue) -> object:
    return [_direction(one) for one in value] if isinstance(value, tuple) else json_number(value)


def _direction(one: Direction) -> dict[str, object]:
    found: dict[str, object] = {"value": json_number(one.value), "direction": dict(one.components)}
    if one.eigenvalue is not None:
        found["eigenvalue"] = [one.eigenvalue.real, one.eigenvalue.imag]
    return found


def _limit(one: Limit) -> Mapping[str, object]:
    return {
        "measure": one.key,
        "target": one.target,
        "limit": json_number(one.limit),
        "value": json_number(one.value),
        "met": one.met,
    }
