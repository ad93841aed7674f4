"""Which other stage of the same file shows a state that one stage does not: motion as a remedy."""

from __future__ import annotations

from dataclasses import replace

from obscli.exact.finding import Analysis
from obscli.pipelines.stage_result import StageResult


def with_other_stages(results: tuple[StageResult, ...]) -> tuple[StageResult, ...]:
    """Add to each stage's advice the states it leaves open that other stages determine."""
    return tuple(_advised(result, results) for result in results)


def _advised(result: StageResult, results: tuple[StageResult, ...]) -> StageResult:
    finding = result.finding
    if not isinstance(finding, Analysis):
        return result
    shown = []
    open_states = {state for state, verdict in finding.states.items() if verdict != "observable"}
    for other in results:
        if other is not result and isinstance(other.finding, Analysis):
            seen = [
                s
                for s, verdict in other.finding.states.items()
                if verdict == "observable" and s in open_states
            ]
            if seen:
                shown.append(f"{other.system.stage or 'the base system'}: {', '.join(seen)}")
    if not shown:
        return result
    line = f"Other stages of this file determine what this one leaves open ({'; '.join(shown)})."
    return replace(result, finding=replace(finding, advice=(*finding.advice, line)))
