"""The system in a line: its size, its parameters, what varies in time."""

from __future__ import annotations

from collections.abc import Iterator

from obscli.core.document import Block, Paragraph, Text
from obscli.core.number import counted
from obscli.exact.finding import Analysis
from obscli.model.notation import to_text
from obscli.pipelines.stage_result import StageResult


def summary_blocks(result: StageResult) -> Iterator[Block]:
    """Yield the system in a line."""
    system, finding = result.system, result.finding
    parts = [f"{counted(system.n, 'state')} (n), {counted(system.m, 'output')} (m)"]
    if system.parameters:
        parts.append("parameters " + ", ".join(parameter.name for parameter in system.parameters))
    if isinstance(finding, Analysis):
        varying = ", ".join(finding.varying)
        parts.append(f"varying in time: {varying}" if varying else "time-invariant")
    if system.discrete:
        seconds = "" if system.step is None else f" of {to_text(system.step)} s"
        parts.append(f"discrete-time, {system.time} counts steps{seconds}")
    yield Paragraph((Text("; ".join(parts)),))
