"""The structure as JSON values."""

from __future__ import annotations

from typing import Final

from obscli.checks.detectability import Detectability, time_constant
from obscli.core.number import json_number
from obscli.exact.finding import Analysis, StateVerdict
from obscli.exact.structure_finding import Mode, Structure
from obscli.pipelines.certificate_data import covector_to_data
from obscli.pipelines.relations_data import relations_data


#: The situation of a coordinate in the method of unobservable states, by its verdict.
SITUATIONS: Final[dict[StateVerdict, int]] = {"observable": 1, "coupled": 2, "unobservable": 3}


def structure_data(finding: Analysis, found: Detectability, there: Detectability | None) -> dict[str, object]:
    """Return ``{unobservable_dimension, verdict, scope, modes, kalman, situations, condition, …}``.

    ``at_values``: the same at the file's values, where more is unobservable than at generic ones.
    """
    structure = finding.structure
    assert structure is not None
    return {
        **_structure(structure),
        **_verdict(found),
        "kalman": None if structure.kalman is None else {"dimensions": list(structure.kalman)},
        "inputs": structure.inputs,
        "situations": {state: SITUATIONS[verdict] for state, verdict in finding.states.items()},
        "at_values": None if there is None else {**_structure(there.of), **_verdict(there)},
        "relations": None if finding.relations is None else relations_data(finding.relations, finding.system),
        "critical": [
            {"where": one.condition, **_structure(one.structure), "verdict": one.structure.verdict}
            for one in structure.critical
        ],
    }


def _structure(structure: Structure) -> dict[str, object]:
    return {
        "unobservable_dimension": structure.dimension,
        "modes": [mode_data(mode) for mode in structure.modes],
        "condition": structure.condition,
    }


def _verdict(found: Detectability) -> dict[str, object]:
    return {"verdict": found.verdict, "scope": found.scope, "reason": found.words}


def mode_data(mode: Mode) -> dict[str, object]:
    """Return one mode; ``kind`` is the one at the file's values where it depends on them."""
    return {
        "eigenvalue": mode.eigenvalue,
        "values": [[value.real, value.imag] for value in mode.values],
        "kind": mode.kind_there if mode.kind == "depends" else mode.kind,
        "condition": mode.condition,
        "chained": mode.chained,
        "time_constant": json_number(time_constant(mode)),
        "direction": covector_to_data(mode.direction),
        "states": list(mode.direction),
    }
