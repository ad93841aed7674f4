"""The structure as JSON values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from obscli.checks.detectability import Detectability, kind_of, time_constant
from obscli.core.number import json_number
from obscli.exact.finding import Analysis, StateVerdict
from obscli.exact.structure_finding import Mode, Structure
from obscli.numeric.finding import HiddenMotion, NotComputed
from obscli.pipelines.certificate_data import covector_to_data
from obscli.pipelines.describe.hidden_motion import said_by_riccati
from obscli.pipelines.relations_data import relations_data
from obscli.pipelines.stage_result import StageResult


#: The situation of a coordinate in the method of unobservable states, by its verdict.
SITUATIONS: Final[dict[StateVerdict, int]] = {"observable": 1, "coupled": 2, "unobservable": 3}


def structure_data(result: StageResult) -> dict[str, object] | None:
    """Return ``{unobservable_dimension, verdict, scope, modes, kalman, situations, condition, …}``.

    ``at_values``: the same at the file's values, where more is unobservable than at generic ones. None where
    the structure was not asked for.
    """
    finding, found, there = result.finding, result.detectability, result.detectability_there
    if not isinstance(finding, Analysis) or finding.structure is None or found is None:
        return None
    structure = finding.structure
    return {
        **_structure(structure),
        **_verdict(found),
        "modes": _modes(structure, found),
        "kalman": None if structure.kalman is None else {"dimensions": list(structure.kalman)},
        "inputs": structure.inputs,
        "situations": {state: SITUATIONS[verdict] for state, verdict in finding.states.items()},
        "at_values": None
        if there is None
        else {**_structure(there.of), **_verdict(there), "modes": _modes(there.of, there)},
        "cross_check": cross_check_data(result),
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


def _modes(structure: Structure, found: Detectability) -> list[dict[str, object]]:
    """Return the modes: those of A22 where it is constant, else of a period, else of the window."""
    motion = found.motion
    if structure.modes or motion is None:
        return [mode_data(mode) for mode in structure.modes]
    if motion.floquet:
        return [
            _followed([one.exponent.real, one.exponent.imag], one.kind, one.direction)
            for one in motion.floquet
        ]
    factors = zip(motion.exponents, motion.errors, motion.directions, strict=True)
    length = motion.stop - motion.start
    return [
        _followed([exponent, 0.0], kind_of(exponent * length, error), one) for exponent, error, one in factors
    ]


def _followed(exponent: list[float], kind: str, direction: Mapping[str, float]) -> dict[str, object]:
    return {"exponent": exponent, "kind": kind, "direction": dict(direction), "states": list(direction)}


def _verdict(found: Detectability) -> dict[str, object]:
    return {
        "verdict": found.verdict,
        "scope": found.scope,
        "reason": found.words,
        "motion": None if found.motion is None else _motion(found.motion),
    }


def _motion(motion: HiddenMotion) -> dict[str, object]:
    """Return the factors by which hidden errors change over a window, and what a period does to them."""
    return {
        "start": motion.start,
        "stop": motion.stop,
        "error": motion.error,
        "modes": [
            {
                "gain": json_number(gain),
                "exponent": json_number(exponent),
                "error": json_number(error),
                "direction": dict(one),
            }
            for gain, exponent, error, one in zip(
                motion.gains, motion.exponents, motion.errors, motion.directions, strict=True
            )
        ],
        "floquet": [
            {
                "multiplier": [one.multiplier.real, one.multiplier.imag],
                "exponent": [one.exponent.real, one.exponent.imag],
                "kind": one.kind,
                "error": one.error,
                "direction": dict(one.direction),
            }
            for one in motion.floquet
        ],
        "multipliers": [[one.real, one.imag] for one in motion.multipliers],
        "multiplier_error": json_number(motion.multiplier_error),
    }


def cross_check_data(result: StageResult) -> dict[str, object] | None:
    """Return deviations from two priors at some instants, how far apart they are, and what that says."""
    found = result.cross_check
    match found:
        case None:
            return None
        case NotComputed(reason):
            return {"reason": reason}
    word = said_by_riccati(result)
    return {
        "says": None if word is None else word.word,
        "words": None if word is None else word.words,
        "t": list(found.instants),
        "apart": [json_number(one) for one in found.apart],
        "standard_deviation": {name: list(values) for name, values in found.deviations.items()},
        "standard_deviation_from_4P0": {name: list(values) for name, values in found.wider.items()},
        "assumed": list(found.assumed),
        "reason": "",
    }


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
