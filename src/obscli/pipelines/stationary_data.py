"""Stationary forms as JSON values."""

from __future__ import annotations

from collections.abc import Sequence

from obscli.core.check import CheckResult
from obscli.exact.lift_finding import Lift, Rows
from obscli.model.notation import covector_text, to_text
from obscli.model.system import Covector
from obscli.numeric.finding import NotComputed
from obscli.pipelines.certificate_data import covector_to_data
from obscli.pipelines.transform_result import NoStationaryForm, StationaryForm, TransformResult


def stationary_data(result: TransformResult, form: StationaryForm) -> dict[str, object]:
    """Return the lifts, the combinations and the checks."""
    found = form.found
    states = result.system.state_names
    outputs = [output.name for output in result.system.outputs]
    return {
        "reducible": True,
        "obstacle": [],
        "full": None if found.full is None else {"n": found.full.n, "rank": found.full.rank},
        "smallest": {
            **_lift(found.smallest, outputs, states),
            "functions": [to_text(one) for one in found.functions.f],
            "S": _rows(found.functions.S, [to_text(one) for one in found.functions.f]),
        },
        "observable": _lift(found.observable, outputs, states),
        "same_order": None if found.same_order is None else _lift(found.same_order, outputs, states),
        "rank": found.rank,
        "combinations": [_form(one, states) for one in found.combinations],
        "chains": [
            {"output": one.output, "forms": [_form(form, states) for form in one.forms]}
            for one in found.chains
        ],
        "agrees": found.agrees,
        "checks": [_check(one) for one in form.checks],
        "notes": list(form.notes),
        "floquet": None,
        "undecided": False,
        "reason": "",
    }


def not_reducible_data(form: NoStationaryForm) -> dict[str, object]:
    """Return what stands in the way, and the Floquet–Lyapunov form of a periodic system."""
    floquet = form.floquet
    numbers = None
    if floquet is not None and not isinstance(floquet, NotComputed):
        from obscli.pipelines.floquet_data import floquet_data  # noqa: PLC0415 - floating point

        numbers = floquet_data(floquet)
    return {
        "reducible": False,
        "obstacle": [
            {"entry": one.entry, "place": one.place, "reason": one.reason} for one in form.found.obstacles
        ],
        "full": None,
        "smallest": None,
        "observable": None,
        "same_order": None,
        "rank": None,
        "combinations": [],
        "chains": [],
        "agrees": None,
        "checks": [],
        "notes": [],
        "floquet": numbers,
        "undecided": False,
        "reason": floquet.reason if isinstance(floquet, NotComputed) else "",
    }


def _lift(lift: Lift, outputs: Sequence[str], states: tuple[str, ...]) -> dict[str, object]:
    return {
        "n": lift.n,
        "variables": [
            {"name": name, **_form(form, states)}
            for name, form in zip(lift.names, lift.variables, strict=True)
        ],
        "A": _named(lift.A, lift.names, lift.names),
        "H": _named(lift.H, outputs, lift.names),
    }


def _form(form: Covector, states: tuple[str, ...]) -> dict[str, object]:
    return {"meaning": covector_text(form, states), "coefficients": covector_to_data(form)}


def _named(rows: Rows, names: Sequence[str], columns: Sequence[str]) -> dict[str, dict[str, str]]:
    """Return a matrix by the names of rows and columns, without zeros."""
    return {
        name: {columns[j]: to_text(entry) for j, entry in sorted(row.items())}
        for name, row in zip(names, rows, strict=True)
    }


def _rows(rows: Rows, functions: Sequence[str]) -> dict[str, dict[str, str]]:
    return _named(rows, functions, functions)


def _check(check: CheckResult) -> dict[str, object]:
    return {"claim": check.claim, "verdict": check.verdict, "reason": check.reason}
