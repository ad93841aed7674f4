"""Figures of an experiment: what each run says of each shared state, deviations against time."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Final

from obscli.core.figure import Curve, Figure, HeatMap, Panel
from obscli.core.number import short
from obscli.model.system import State
from obscli.pipelines.calibration_result import CalibrationResult


if TYPE_CHECKING:
    from obscli.experiment.accuracy import Accuracy

#: Curves in one panel.
CURVES: Final = 3

#: Panels in one figure.
PANELS: Final = 4

SHADES: Final = {"observable": 1.0, "coupled": 0.45, "unobservable": 0.0}
WORDS: Final = {"observable": "●", "coupled": "◐", "unobservable": "·"}


def calibration_figures(results: Iterable[CalibrationResult]) -> Iterator[Figure]:
    """Yield a heat map of shared states × runs, and the deviations against time where there is noise."""
    for result in results:
        yield Figure(
            f"{result.title}-map", f"{result.title}: what each run determines", "", (verdict_map(result),)
        )
        if result.accuracy is not None:
            yield Figure(
                f"{result.title}-gain",
                f"{result.title}: what each run alone gains over the prior",
                "",
                (gain_map(result),),
            )
            yield from deviation_figures(
                result.title,
                result.exact.stack.system.states,
                result.exact.stack.system.time,
                result.accuracy,
            )


def verdict_map(result: CalibrationResult) -> HeatMap:
    """Return shared states × runs: determined, in combination, not at all."""
    verdicts = [[one.verdict(state) for one in result.runs] for state in result.exact.shared]
    return HeatMap(
        "what each run alone says of each shared state",
        result.exact.shared,
        tuple(one.run.name for one in result.runs),
        tuple(tuple(None if v is None else SHADES[v] for v in row) for row in verdicts),
        tuple(tuple("?" if v is None else WORDS[v] for v in row) for row in verdicts),
        "dark: determined; grey: only in combination; white: in no combination of shared states",
    )


def gain_map(result: CalibrationResult) -> HeatMap:
    """Return shared states × runs: how many times smaller each run alone makes the deviation."""
    assert result.accuracy is not None
    states = result.accuracy.states
    gains = [[_gain(one.before, alone) for alone in one.alone] for one in states]
    finite = [gain for row in gains for gain in row if gain is not None]
    largest = max(finite, default=1.0)
    return HeatMap(
        "how many times better each shared state is known after each run alone",
        tuple(one.name for one in states),
        tuple(one.run.name for one in result.runs),
        tuple(tuple(None if g is None else _shade(g, largest) for g in row) for row in gains),
        tuple(tuple("–" if g is None else short(g, 3) for g in row) for row in gains),
        f"dark: {round(largest)} times better (logarithmic); white: no better; –: no prior to compare",
    )


def _gain(before: float, after: float) -> float | None:
    return before / after if math.isfinite(before) and 0 < after < math.inf else None


def _shade(gain: float, largest: float) -> float:
    return max(0.0, math.log(gain) / math.log(largest)) if largest > 1 and gain > 0 else 0.0


def deviation_figures(title: str, states: Sequence[State], time: str, found: Accuracy) -> Iterator[Figure]:
    """Yield the deviations against time, states of one vector in a panel, with what is required."""
    required = {one.name: one.required for one in found.required}
    vectors: dict[str, list[int]] = {}
    for j, state in enumerate(states):
        vectors.setdefault(state.vector or "", []).append(j)
    parts = [some[k : k + CURVES] for some in vectors.values() for k in range(0, len(some), CURVES)]
    panels = [_panel(states, found, part, required) for part in parts]
    for k in range(0, len(panels), PANELS):
        part = f"-{k // PANELS + 1}" if len(panels) > PANELS else ""
        yield Figure(
            f"{title}-deviations{part}",
            f"{title}: standard deviations over the runs",
            f"{time} since the start of the first run, without setting up",
            tuple(panels[k : k + PANELS]),
        )


def _names(states: Sequence[State], indices: list[int]) -> str:
    return " ".join(states[j].name for j in indices)


def _panel(states: Sequence[State], found: Accuracy, indices: list[int], required: dict[str, float]) -> Panel:
    times = found.history.times
    curves: list[Curve] = []
    for j in indices:
        pairs = [(t, v) for t, v in zip(times, found.history.values[j], strict=True) if math.isfinite(v)]
        if pairs:
            t, values = zip(*pairs, strict=True)
            curves.append(Curve(states[j].name, t, values, STYLES[len(curves) % len(STYLES)]))
    asked = sorted({required[states[j].name] for j in indices if states[j].name in required})
    curves += [Curve("required", (times[0], times[-1]), (value, value), "limit") for value in asked]
    first = states[indices[0]]
    unit = f" [{first.unit}]" if first.unit else ""
    return Panel(
        _names(states, indices), f"σ{unit}", tuple(curves), logarithmic=True, marks=found.history.ends[:-1]
    )


STYLES: Final = ("main", "reference", "one of many")
