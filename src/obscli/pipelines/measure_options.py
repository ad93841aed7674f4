"""What was asked of measures, as texts: which, with which options, held against which values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf, isnan, nan
from typing import TypeAlias

from obscli.measures.catalogue import BY_KEY, MEASURES
from obscli.measures.measure import Measure, Option
from obscli.pipelines.reading import unknown
from obscli.pipelines.request import RequestError


#: Options of measures by key and name.
Options: TypeAlias = Mapping[str, Mapping[str, float | str]]


def chosen_measures(select: Sequence[str]) -> tuple[Measure, ...]:
    """Return the measures of some keys in order, unasked all but habits; an unknown key is refused."""
    if not select:
        return tuple(one for one in MEASURES if one.always)
    for key in select:
        if key not in BY_KEY:
            raise RequestError(unknown("--select: no measure", key, list(BY_KEY)))
    return tuple(one for one in MEASURES if one.key in select)


def measure_options(chosen: Sequence[Measure], given: Mapping[str, str]) -> Options:
    """Return the options of all measures, those given read."""
    found = {one.key: {option.name: option.default for option in one.options} for one in MEASURES}
    known = {f"{one.key}.{option.name}": option for one in MEASURES for option in one.options}
    for path, text in given.items():
        if path not in known:
            raise RequestError(unknown("--option: no option", path, list(known)))
        key, _, name = path.partition(".")
        if BY_KEY[key] not in chosen:
            raise RequestError(f"--option {path}: the measure {key} is not selected")
        found[key][name] = _read(path, text, known[path])
    return found


def _read(path: str, text: str, option: Option) -> float | str:
    if option.choices:
        if text not in option.choices:
            raise RequestError(f"--option {path}: {text!r} is not one of {', '.join(option.choices)}")
        return text
    try:
        value = float(text)
    except ValueError:
        value = nan
    if not 0 < value < inf or (option.whole and value != round(value)):
        kind = "whole number" if option.whole else "number"
        raise RequestError(f"--option {path}: a positive {kind} is expected, not {text!r}")
    return value


def thresholds_of(chosen: Sequence[Measure], given: Mapping[str, str]) -> dict[str, float]:
    """Return the values that measures are held against; raises ``RequestError`` where one is no number."""
    found: dict[str, float] = {}
    for key, text in given.items():
        if key not in BY_KEY or BY_KEY[key].better is None:
            raise RequestError(unknown("--threshold: no measure of states", key, _with_values()))
        if BY_KEY[key] not in chosen:
            raise RequestError(f"--threshold {key}: this measure is not selected")
        try:
            found[key] = float(text)
        except ValueError:
            found[key] = nan
        if isnan(found[key]):
            raise RequestError(f"--threshold {key}: a number is expected, not {text!r}")
    return found


def _with_values() -> list[str]:
    return [one.key for one in MEASURES if one.better is not None]
