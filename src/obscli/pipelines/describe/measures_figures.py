"""Figures of measures against time: the share that measurements take away, deviations with their bounds."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Final

from obscli.core.figure import Curve, Emphasis, Figure, Panel
from obscli.measures.subject import Target
from obscli.pipelines.measures_result import Curves, MeasuresResult


#: Targets in one figure.
PANELS: Final = 8
SHARES: Final = 6

#: What a deviation is held against.
BESIDE: Final[tuple[tuple[str, str, Emphasis], ...]] = (
    ("open-loop", "without measurements", "one of many"),
    ("cramer-rao", "Cramér–Rao bound", "reference"),
)


def measures_figures(results: Iterable[MeasuresResult]) -> Iterator[Figure]:
    """Yield the figures of every stage with noise."""
    for result in results:
        if result.curves is not None and isinstance(result.taken, tuple):
            yield from _figures(result, result.curves)


def _figures(result: MeasuresResult, curves: Curves) -> Iterator[Figure]:
    assert isinstance(result.taken, tuple)
    targets = result.taken[-1].subject.targets
    shown = [k for k, one in enumerate(targets) if one.kind != "combination"]
    if "stochastic" in curves.values:
        yield Figure(
            f"{result.title}-stochastic",
            f"{result.title}: stochastic measure",
            result.system.time,
            tuple(_shares(curves, targets, group) for group in _groups(shown, SHARES)),
        )
    if "standard-deviation" in curves.values:
        groups = _groups(shown, PANELS)
        for number, group in enumerate(groups, 1):
            yield Figure(
                f"{result.title}-deviation" + (f"-{number}" if len(groups) > 1 else ""),
                f"{result.title}: standard deviations",
                result.system.time,
                tuple(_deviation(result, curves, targets[k], k) for k in group),
            )


def _groups(shown: Sequence[int], size: int) -> list[Sequence[int]]:
    return [shown[first : first + size] for first in range(0, len(shown), size)]


def _shares(curves: Curves, targets: Sequence[Target], group: Sequence[int]) -> Panel:
    """Return what measurements take away of some targets."""
    lines = tuple(_curve(_label(targets[k]), curves, "stochastic", k) for k in group)
    return Panel("share of the deviation that measurements take away", "1 − σ⁺/σ⁻", lines)


def _deviation(result: MeasuresResult, curves: Curves, target: Target, k: int) -> Panel:
    """Return the deviation of one target, with the bound and what is required."""
    lines = [_curve("filter", curves, "standard-deviation", k)]
    for key, label, emphasis in BESIDE:
        if key in curves.values and any(map(math.isfinite, curves.values[key][:, k])):
            lines.append(_curve(label, curves, key, k, emphasis))
    ends = (float(curves.t[0]), float(curves.t[-1]))
    lines += [
        Curve("required", ends, (limit.limit, limit.limit), "limit")
        for limit in result.limits
        if limit.key == "standard-deviation" and limit.target == target.name
    ]
    unit = next((one.unit for one in result.system.states if one.name == target.name), "")
    return Panel(_label(target), f"σ, {unit}" if unit else "σ", tuple(lines), logarithmic=True)


def _label(target: Target) -> str:
    return target.name if target.observable else f"{target.name} (not observable)"


def _curve(label: str, curves: Curves, key: str, k: int, emphasis: Emphasis = "main") -> Curve:
    """Return a curve, broken where there is no number."""
    values = (float(value) if math.isfinite(value) else math.nan for value in curves.values[key][:, k])
    return Curve(label, tuple(map(float, curves.t)), tuple(values), emphasis)
