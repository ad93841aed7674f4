"""The Gramians of an experiment against its exact side, and the verdict in plain words."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from obscli.core.document import (
    Block,
    Cell,
    Column,
    Details,
    Heading,
    Kind,
    Listing,
    Paragraph,
    Table,
    Text,
    VerdictLine,
    line,
    plain,
)
from obscli.core.number import counted, short
from obscli.core.verification import NotVerified, Verification
from obscli.exact.finding import Analysis, Undecided
from obscli.pipelines.calibration_result import CalibrationResult, RunResult
from obscli.pipelines.describe.verification import KINDS, comparison_blocks
from obscli.pipelines.describe.words import ratio


CHECK_COLUMNS: Final = (
    Column("#", "right"),
    Column("rank", "right"),
    Column("instants", "right"),
    Column("worst χ", "right"),
    Column("bound", "right"),
    Column("least gap", "right"),
    Column(breaks=True),
)
LEGEND: Final = (
    "The whole analysis of each run against its Gramian, then all runs together at fractions of their "
    "durations, the states that start anew eliminated; χ: the largest leak of a combination into the kernel; "
    "bound: what rounding may account for."
)
#: Runs named in advice.
MOST: Final = 12
SIGNS: Final = {"verified": "✓", "contradicted": "✗", "undecided": "?", "not excited": "○"}
ROLES: Final = {"verified": "good", "contradicted": "bad", "undecided": "open", "not excited": "open"}


def calibration_verdict_blocks(result: CalibrationResult) -> Iterator[Block]:
    """Yield the comparison run by run, that of all runs together, the verdict, and what to do."""
    if result.shown is None:
        yield Heading(2, plain("Analysis and Gramians"))
        rows = [_row(str(k), one.verification) for k, one in enumerate(result.runs, start=1)]
        rows.append(_row("all", result.verification))
        yield Table(CHECK_COLUMNS, tuple(rows), (Text(LEGEND, "faint"),))
        for label, found in _worth_a_look(result):
            yield Paragraph(plain(f"{label}: {found.diagnosis.replace('observable', 'determined')}"))
            yield Details(tuple(comparison_blocks(found)))
    yield Heading(2, plain("Verdict"))
    for kind, text in _verdicts(result):
        yield VerdictLine(kind, plain(text))
    advice = tuple(plain(one) for one in _advice(result))
    if advice:
        yield Heading(2, plain("What to do"))
        yield Listing(advice, numbered=len(advice) > 1)


def _row(label: str, found: Verification | NotVerified | None) -> tuple[Cell, ...]:
    if not isinstance(found, Verification):
        why = "" if found is None else found.reason
        return (line(Text(label)), *(line(Text("–")) for _ in range(5)), line(Text(f"? {why}", "open")))
    worst = found.worst
    conclusive = [p for p in found.points if p.conclusive]
    gaps = [p.gap for p in conclusive if p.gap is not None]
    text = SIGNS[found.verdict]
    if found.verdict != "verified":
        text += f" {found.reason}"
    role = {"verified": "good", "contradicted": "bad"}.get(found.verdict, "open")
    return (
        line(Text(label)),
        line(Text(str(found.n - conclusive[-1].q) if conclusive else "?")),
        line(Text(f"{found.agree} of {len(found.points)}")),
        line(Text("–" if worst is None or worst.chi is None else short(worst.chi))),
        line(Text("–" if worst is None or worst.bound is None else short(worst.bound))),
        line(Text(short(min(gaps)) if gaps else "–")),
        line(Text(text, role)),  # type: ignore[arg-type]
    )


def _worth_a_look(result: CalibrationResult) -> Iterator[tuple[str, Verification]]:
    """Yield the comparisons that do not agree, and the joint one."""
    for one in result.runs:
        if isinstance(one.verification, Verification) and one.verification.verdict != "verified":
            yield one.run.name, one.verification
    if isinstance(result.verification, Verification):
        yield "all runs together", result.verification


def _verdicts(result: CalibrationResult) -> Iterator[tuple[Kind, str]]:
    finding = result.exact.stack.finding
    if isinstance(finding, Undecided):
        yield "open", f"undecided exactly: {finding.reason}"
    else:
        yield (
            "good" if result.shown or result.verification is None else _kind(result),
            _together(result, finding),
        )
    yield from _runs_verdict(result)
    if result.accuracy is not None and result.accuracy.required:
        yield _required_verdict(result)
    elif result.asks_in_vain:
        yield "open", f"whether the requirements are met is open: {result.no_accuracy}"


def _kind(result: CalibrationResult) -> Kind:
    found = result.verification
    return KINDS[found.verdict] if isinstance(found, Verification) else "open"


def _together(result: CalibrationResult, finding: Analysis) -> str:
    n = len(result.exact.shared)
    runs = counted(len(result.runs), "run")
    verb = "determines" if len(result.runs) == 1 else "determine"
    words = f"proved exactly (generic): {runs} {verb} {finding.rank} of {n}"
    there = result.exact.at_file
    if there.rank is not None and there.rank != finding.rank:
        because = f", because {', '.join(there.because)}" if there.because else ""
        words += f"; at your values {there.rank}{because}"
    match result.verification:
        case Verification() as found:
            return f"{words}; {_compared(found)}"
        case NotVerified(reason):
            return f"{words}; not checked against the Gramians: {reason}"
    return words


def _compared(found: Verification) -> str:
    if found.verdict == "verified":
        return f"the Gramians agree at {found.agree} of {len(found.points)} fractions of the runs"
    if found.verdict == "contradicted":
        return f"contradicted by the Gramians: {found.reason}"
    if found.verdict == "not excited":
        return found.reason
    return f"undecided against the Gramians: {found.reason}"


def _runs_verdict(result: CalibrationResult) -> Iterator[tuple[Kind, str]]:
    by: dict[str, list[RunResult]] = {}
    for one in result.runs:
        if isinstance(one.verification, Verification):
            by.setdefault(one.verification.verdict, []).append(one)
        elif one.verification is not None:
            by.setdefault("undecided", []).append(one)
    for verdict, runs in by.items():
        listed = ", ".join(one.run.name for one in runs)
        everyone = len(runs) == len(result.runs)
        if verdict == "verified":
            who = "every run" if everyone else listed
            yield "good", f"the Gramian agrees with the analysis of {who}"
        elif verdict == "contradicted":
            yield "bad", f"the Gramian contradicts the analysis of {listed}"
        elif verdict == "not excited":
            yield "open", f"the recorded signals do not excite everything in {listed}"
        else:
            yield "open", f"the Gramian leaves open: {listed}"


def _required_verdict(result: CalibrationResult) -> tuple[Kind, str]:
    assert result.accuracy is not None
    required, worst = result.accuracy.required, result.accuracy.worst
    assert worst is not None
    failed = [one for one in required if not one.is_met]
    margin = f"worst margin {ratio(worst.margin)} ({worst.name})"
    if failed:
        return "bad", f"{len(failed)} of {counted(len(required), 'requirement')} not met, {margin}"
    everything = "the requirement is" if len(required) == 1 else f"all {len(required)} requirements are"
    return "good", f"{everything} met, {margin}"


def _advice(result: CalibrationResult) -> Iterator[str]:
    finding = result.exact.stack.finding
    if not isinstance(finding, Analysis):
        return
    missing = finding.system.n - finding.rank
    idle = [str(k) for k, rows in enumerate(result.exact.stack.adds, start=1) if not rows]
    if missing:
        directions = counted(missing, "direction")
        yield (
            f"{directions} of the shared states cannot be determined by these runs; `obscli plan` tries "
            "which kind of run would, and finds the smallest sets of runs."
        )
    elif idle and len(result.runs) > 1:
        runs, does = ("run", "determines") if len(idle) == 1 else ("runs", "determine")
        named = ", ".join(idle[:MOST]) + (", …" if len(idle) > MOST else "")
        yield (
            f"{runs} {named} {does} nothing new, only the accuracy gains. `obscli plan` finds the smallest "
            "sets of runs."
        )
