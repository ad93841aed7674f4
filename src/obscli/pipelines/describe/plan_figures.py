"""Figures of a plan: what each candidate determines, deviations over the plan."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from obscli.core.figure import Figure, HeatMap
from obscli.pipelines.describe.calibration_figures import SHADES, WORDS, deviation_figures
from obscli.pipelines.plan_result import PlanResult


def plan_figures(results: Iterable[PlanResult]) -> Iterator[Figure]:
    """Yield the heat map of shared states × candidates, and the deviations over the plan."""
    for result in results:
        plan = result.plan
        yield Figure(
            f"{result.title}-map", f"{result.title}: what each candidate determines", "", (_map(result),)
        )
        if result.accuracy is not None:
            states = plan.stack.system.states
            yield from deviation_figures(result.title, states, plan.stack.system.time, result.accuracy)


def _map(result: PlanResult) -> HeatMap:
    runs = result.plan.stack.runs
    verdicts = [[one.verdict(state) or "unobservable" for one in runs] for state in result.plan.shared]
    return HeatMap(
        "what each candidate alone says of each shared state",
        result.plan.shared,
        tuple(f"{k} {one.run.name}" for k, one in enumerate(runs, start=1)),
        tuple(tuple(SHADES[verdict] for verdict in row) for row in verdicts),
        tuple(tuple(WORDS[verdict] for verdict in row) for row in verdicts),
        "dark: determined; grey: only in combination; white: in no combination of shared states",
    )
