"""What ``expect`` says of measures and requirements, checked at the values of the claim."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from obscli.core.check import CheckResult
from obscli.core.number import short
from obscli.core.place import Place
from obscli.exact.finding import Undecided
from obscli.measures.catalogue import BY_KEY, MEASURES
from obscli.measures.measure import Found
from obscli.model.expression import Expression
from obscli.model.specialise import Specialisation
from obscli.model.system import Claim, ExpectedMeasure, Model, System
from obscli.numeric.finding import NotComputed
from obscli.numeric.numeric_system import constants_of
from obscli.numeric.program import constant_value
from obscli.pipelines.measures import measure_stage
from obscli.pipelines.measures_result import Limit, MeasuresResult, Taken
from obscli.pipelines.request import MeasuresRequest


#: How far off a value may be where the file does not say, relative to it.
_TOLERANCE = 1e-6


def check_measures(model: Model, system: System, claim: Claim) -> Iterator[CheckResult]:
    """Check every value expected of a measure, and whether requirements are met, one result each.

    Parameters
    ----------
    system : the stage that the claim is about
    """
    if not (claim.measures or claim.requirements):
        return
    there = Specialisation(system, claim.at).system() if isinstance(claim.at, Mapping) else system
    known = {one.key for one in claim.measures if one.key in BY_KEY}
    if claim.requirements:
        known.add("standard-deviation")
    whole = any(one.key not in BY_KEY for one in claim.measures)
    select = tuple(one.key for one in MEASURES if one.key in known or (whole and one.always))
    result = measure_stage(model, there, MeasuresRequest(select=select))
    for expected in claim.measures:
        yield _measure(result, expected)
    for name, (word, place) in claim.requirements.items():
        for limit in (one for one in result.limits if name in ("", one.target)):
            yield _requirement(limit, word, place)


def _measure(result: MeasuresResult, expected: ExpectedMeasure) -> CheckResult:
    wanted = _wanted(result.system, expected)
    of = f" of {expected.target}" if expected.target else ""
    claim = f"{expected.key}{of} is {short(wanted, 6)}"
    if isinstance(result.taken, Undecided | NotComputed):
        return CheckResult(claim, "undecided", result.taken.reason, expected.place)
    value = _value(result.taken[-1], expected)
    if isinstance(value, str):
        return CheckResult(claim, "undecided" if expected.key in BY_KEY else "fails", value, expected.place)
    tolerance = _TOLERANCE if expected.tolerance is None else _number(result.system, expected.tolerance)
    near = math.isfinite(wanted) and abs(value - wanted) <= tolerance * abs(wanted)
    agrees = value == wanted or near
    reason = f"measured: {short(value, 8)}, expected within {short(tolerance)} of the value"
    return CheckResult(claim, "holds" if agrees else "fails", reason, expected.place)


def _wanted(system: System, expected: ExpectedMeasure) -> float:
    return math.inf if expected.value is None else _number(system, expected.value)


def _number(system: System, value: Expression) -> float:
    return constant_value(value, constants_of(system))


def _value(taken: Taken, expected: ExpectedMeasure) -> float | str:
    """Return what was measured, or why nothing was."""
    if expected.key in BY_KEY:
        found = taken.found[expected.key]
        if not isinstance(found, Found):
            return found.reason
    if expected.target is None:
        each = [one for one in taken.found.values() if isinstance(one, Found)]
        values = {key: one for found in each for key, one in found.system.items()}
        value = values.get(expected.key)
        if isinstance(value, float | int):
            return float(value)
        return f"there is no single value {expected.key} of the system; there are: " + ", ".join(
            key for key, one in values.items() if not isinstance(one, tuple)
        )
    value = taken.value(expected.key, expected.target)
    return f"{expected.key} has no value for {expected.target}" if value is None else value


def _requirement(limit: Limit, word: str, place: Place) -> CheckResult:
    claim = f"the accuracy of {limit.target} is {word}"
    if limit.met is None or limit.value is None:
        return CheckResult(claim, "undecided", "the standard deviation is not known", place)
    reason = f"standard deviation {short(limit.value, 4)}, at most {short(limit.limit, 4)} asked for"
    agrees = limit.met == (word == "met")
    return CheckResult(claim, "holds" if agrees else "fails", reason, place)
