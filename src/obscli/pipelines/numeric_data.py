"""The numerical side and its comparison with the exact one as JSON values."""

from __future__ import annotations

from collections.abc import Mapping

from obscli.core.check import CheckResult, Counterexample, Indicator
from obscli.core.number import json_number
from obscli.core.verification import CombinationCheck, NotVerified, Point, Verification
from obscli.model.notation import to_text
from obscli.numeric.finding import (
    CoefficientCurve,
    EchelonFinding,
    NotComputed,
    NumericFinding,
    NumericPoint,
    SignalsFinding,
)


def numeric_data(found: NumericFinding | NotComputed | None) -> dict[str, object] | None:
    """Return ``{method, scaling, tolerance, points, …}``; ``reason`` instead where nothing was computed."""
    match found:
        case None:
            return None
        case NotComputed(reason):
            return {"method": None, "scaling": None, "tolerance": None, "points": [], "reason": reason}
    return {
        "method": found.method,
        "scaling": found.scaling,
        "rtol": found.rtol,
        "tolerance": json_number(max((p.tolerance for p in found.points), default=0.0)),
        "interval": {"start": found.start, "default": found.default},
        "window": json_number(found.window),
        "sampled": list(found.sampled),
        **({} if found.signals is None else {"signals": _signals(found.signals)}),
        "rank": found.rank,
        "states": dict(found.states),
        "groups": [list(group) for group in found.groups],
        "points": [_point(point) for point in found.points],
        "reason": "",
    }


def _signals(found: SignalsFinding) -> dict[str, object]:
    return {
        "files": [
            {
                "file": one.file,
                "names": list(one.names),
                "samples": one.count,
                "start": one.start,
                "stop": one.stop,
                "interpolation": one.interpolation,
            }
            for one in found.files
        ],
        "noise": dict(found.noise),
        "exact": not found.noise,
        "t": found.t,
        "shown": found.shown,
        "clear": found.clear,
        "excited": found.excited,
        "calm": found.calm,
        "ratios": [json_number(ratio) for ratio in found.ratios],
        "not_excited": list(found.not_excited),
        "reason": found.reason,
        "doubts": list(found.doubts),
    }


def _point(point: NumericPoint) -> dict[str, object]:
    data: dict[str, object] = {
        "t": point.t,
        "start": point.start,
        "rank": point.rank,
        "decided": point.decided,
        "gap": json_number(point.gap),
        "tolerance": json_number(point.tolerance),
        "singular_values": [json_number(value) for value in point.singular_values],
    }
    if point.stop is not None:
        data["stop"] = point.stop
    if point.basis is not None:
        data["basis"] = [list(row) for row in point.basis]
    return data


def basis_data(found: EchelonFinding | None) -> dict[str, object] | None:
    """Return the basis in time: pivots, and each coefficient with its guessed form."""
    if found is None:
        return None
    return {"pivots": list(found.pivots), "coefficients": [_curve(one) for one in found.curves]}


def _curve(one: CoefficientCurve) -> dict[str, object]:
    guess = one.guess
    return {
        "pivot": one.pivot,
        "state": one.free,
        "guess": None if guess.expression is None else to_text(guess.expression),
        "standing": one.standing,
        "reason": guess.reason,
        "residual": json_number(guess.residual),
        "held_back": json_number(guess.held_back),
        "t": list(one.instants),
        "values": [json_number(value) for value in one.values],
        "errors": [json_number(error) for error in one.errors],
    }


def verification_data(found: Verification | NotVerified | None) -> dict[str, object] | None:
    """Return ``{verdict, points, combinations, diagnosis, …}``."""
    match found:
        case None:
            return None
        case NotVerified(reason):
            return {
                "verdict": "undecided",
                "reason": reason,
                "points": [],
                "combinations": [],
                "diagnosis": reason,
            }
    return {
        "verdict": found.verdict,
        "reason": found.reason,
        "n": found.n,
        "points": [_verified(point) for point in found.points],
        "combinations": [_combination(one) for one in found.combinations],
        "diagnosis": found.diagnosis,
    }


def _verified(point: Point) -> dict[str, object]:
    return {
        "t": point.t,
        "r": point.r,
        "q": point.q,
        "chi": json_number(point.chi),
        "bound": json_number(point.bound),
        "gap": json_number(point.gap),
        "conclusive": point.conclusive,
        "agrees": point.agrees,
    }


def _combination(one: CombinationCheck) -> dict[str, object]:
    return {
        "expression": one.expression,
        "chi": json_number(one.chi),
        "bound": json_number(one.bound),
        "holds": one.holds,
        "correction": one.correction or None,
    }


def evidence_data(check: CheckResult) -> dict[str, object]:
    """Return what a check rests on beside its reason: the Gramian, corrections, a counterexample, T(t)."""
    return {
        "gramian": _indicator(check.gramian),
        "corrections": [
            {"of": one.of, "change": one.change, "corrected": one.corrected, "words": one.words}
            for one in check.corrections
        ],
        "counterexample": _counterexample(check.counterexample),
        "transformation": [list(row) for row in check.transformation],
        "basis": verification_data(check.verification),
    }


def _indicator(one: Indicator | None) -> Mapping[str, object] | None:
    if one is None:
        return None
    return {"agree": one.agree, "of": one.of, "chi": json_number(one.chi), "bound": json_number(one.bound)}


def _counterexample(one: Counterexample | None) -> Mapping[str, object] | None:
    if one is None:
        return None
    found = one.trajectories
    return {
        "direction": dict(one.direction),
        "claim": one.claim,
        "is_trajectory": one.is_trajectory,
        "trajectories": None
        if found is None
        else {
            "t": list(found.instants),
            "difference": {state: list(values) for state, values in found.difference.items()},
            "claim": list(found.claim),
            "output": json_number(found.output),
        },
    }
