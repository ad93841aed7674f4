"""Transformed systems as JSON values."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from obscli.core.check import CheckResult
from obscli.core.version import SCHEMA, VERSION
from obscli.exact.finding import Undecided
from obscli.model.notation import covector_text, to_text
from obscli.model.system import Matrix
from obscli.pipelines.certificate_data import covector_to_data
from obscli.pipelines.request import Changes
from obscli.pipelines.stationary_data import not_reducible_data, stationary_data
from obscli.pipelines.transform_heading import back_forms
from obscli.pipelines.transform_result import (
    NoStationaryForm,
    NothingLeft,
    StationaryForm,
    Transformed,
    TransformResult,
)


def transform_data(results: Iterable[TransformResult], changes: Changes) -> dict[str, object]:
    """Return ``{schema, obscli, changes, results}``, one entry of ``results`` a stage."""
    return {
        "schema": SCHEMA,
        "obscli": VERSION,
        "changes": changes.data(),
        "results": [_result(result) for result in results],
    }


def _result(result: TransformResult) -> dict[str, object]:
    system = result.system
    return {
        "model": {"name": result.model.name, "file": str(result.model.file), "stage": system.stage},
        "n": system.n,
        "m": system.m,
        "states": list(system.state_names),
        "transform": {"to": result.to, **_finding(result)},
    }


def _finding(result: TransformResult) -> dict[str, object]:
    match result.finding:
        case Transformed() as found:
            return _transformed(result, found)
        case StationaryForm() as found:
            return stationary_data(result, found)
        case NoStationaryForm() as found:
            return not_reducible_data(found)
        case NothingLeft(reason) | Undecided(_, reason):
            return {**_EMPTY, "undecided": isinstance(result.finding, Undecided), "reason": reason}


#: The keys of a transformation that came to nothing.
_EMPTY: dict[str, object] = {
    "n": 0,
    "variables": [],
    "discrete": False,
    "A": {},
    "H": {},
    "B": None,
    "G": None,
    "back": {},
    "left_out": [],
    "moved": [],
    "exact": None,
    "checks": [],
    "dimensions": [],
    "inputs": None,
    "divides_by": [],
    "notes": [],
}


def _transformed(result: TransformResult, found: Transformed) -> dict[str, object]:
    made, names = found.system, found.system.state_names
    outputs = [output.name for output in made.outputs]
    return {
        "n": made.n,
        "variables": [
            {
                "name": name,
                "meaning": covector_text(form, result.system.state_names),
                "coefficients": covector_to_data(form),
            }
            for name, form in zip(names, found.forms, strict=True)
        ],
        "discrete": made.discrete,
        "A": _matrix(made.A, names, names),
        "H": _matrix(made.H, outputs, names),
        "B": None if made.B is None else _matrix(made.B, names, made.inputs),
        "G": None if made.G is None else _matrix(made.G, names, made.disturbances),
        "back": {s: covector_to_data(form) for s, form in back_forms(names, found.back).items()},
        "left_out": list(found.left_out),
        "moved": list(found.moved),
        "exact": found.is_exact,
        "checks": [_check(check) for check in found.checks],
        "dimensions": list(found.sizes),
        "inputs": found.by,
        "divides_by": [to_text(one) for one in found.divides_by],
        "notes": list(found.notes),
        "undecided": False,
        "reason": "",
    }


def _matrix(matrix: Matrix, rows: Sequence[str], columns: Sequence[str]) -> dict[str, dict[str, str]]:
    """Return a matrix by the names of rows and columns, without zeros."""
    found: dict[str, dict[str, str]] = {name: {} for name in rows}
    for (i, j), entry in sorted(matrix.entries.items()):
        found[rows[i]][columns[j]] = to_text(entry)
    return found


def _check(check: CheckResult) -> dict[str, object]:
    return {"claim": check.claim, "verdict": check.verdict, "reason": check.reason}
