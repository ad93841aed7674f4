"""The two sides held against each other: χ and the rank check, and the verdict in plain words."""

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
    Paragraph,
    Table,
    Text,
    VerdictLine,
    line,
    plain,
)
from obscli.core.number import short
from obscli.core.verification import CombinationCheck, NotVerified, Point, Verification
from obscli.exact.finding import Analysis, Undecided
from obscli.numeric.finding import NotComputed, NumericFinding, SignalsFinding
from obscli.pipelines.describe.instants import runs, span
from obscli.pipelines.stage_result import StageResult


POINT_COLUMNS: Final = (
    Column("t"),
    Column("r", "right"),
    Column("q", "right"),
    Column("r + q", "right"),
    Column("n", "right"),
    Column("χ", "right"),
    Column("bound", "right"),
    Column("gap", "right"),
    Column(),
)
LEGEND: Final = (
    "r combinations, kernel of dimension q, χ the largest leak of a combination into it, and what rounding "
    "may account for; gap: on which q rests. Of several instants: the largest χ, its bound, the least gap."
)
COMBINATION_COLUMNS: Final = (
    Column("combination", breaks=True),
    Column("χ", "right"),
    Column("bound", "right"),
    Column(),
)
KINDS: Final[dict[str, Kind]] = {
    "verified": "good",
    "contradicted": "bad",
    "undecided": "open",
    "not excited": "info",
}


def verification_blocks(result: StageResult) -> Iterator[Block]:
    """Yield the report of χ and the rank check, where both sides were run."""
    found = result.verification
    if found is None:
        return
    yield Heading(2, plain("Analysis and Gramian"))
    if isinstance(found, NotVerified):
        yield Paragraph(plain(f"Not compared: {found.reason}"))
        return
    yield from comparison_blocks(found)


def comparison_blocks(found: Verification) -> Iterator[Block]:
    """Yield one comparison: instants put together, the diagnosis, the combinations that leak."""
    rows = tuple(
        _row(found, run) for run in runs(found.points, lambda p: (p.q, p.conclusive, p.agrees, p.refutes))
    )
    yield Table(POINT_COLUMNS, rows, (Text(LEGEND, "faint"),))
    every = Table(POINT_COLUMNS, tuple(_row(found, (point,)) for point in found.points))
    yield Details((Paragraph(plain("At every instant:")), every))
    yield Paragraph(plain(found.diagnosis))
    leaking = tuple(_combination(one) for one in found.combinations if one.holds is False)
    if leaking:
        yield Table(COMBINATION_COLUMNS, leaking)
    others = tuple(_combination(one) for one in found.combinations if one.holds is not False)
    every_one = "Every other combination" if leaking else "Every combination"
    yield Details((Paragraph(plain(f"{every_one}, at its worst:")), Table(COMBINATION_COLUMNS, others)))


def _row(found: Verification, run: tuple[Point, ...]) -> tuple[Cell, ...]:
    first = run[0]
    compared = [p for p in run if p.chi is not None]
    worst = max(compared, key=lambda p: p.chi or 0.0, default=None)
    gaps = [p.gap for p in run if p.gap is not None]
    total = first.r + first.q
    return (
        line(Text(span(run))),
        line(Text(str(first.r))),
        line(Text(str(first.q))),
        line(Text(str(total), "plain" if total == found.n else "bad")),
        line(Text(str(found.n))),
        line(Text("–" if worst is None or worst.chi is None else short(worst.chi))),
        line(Text("–" if worst is None or worst.bound is None else short(worst.bound))),
        line(Text(short(min(gaps)) if gaps else "–")),
        line(_sign(first)),
    )


def _sign(point: Point) -> Text:
    if not point.conclusive:
        return Text("? not clear", "open")
    if point.agrees:
        return Text("✓", "good")
    return Text("✗", "bad") if point.refutes else Text("? χ above its bound", "open")


def _combination(one: CombinationCheck) -> tuple[Cell, ...]:
    word = {True: "", False: "leaks", None: "not clear"}[one.holds]
    return (
        line(Text(one.expression)),
        line(Text("–" if one.chi is None else short(one.chi))),
        line(Text("–" if one.bound is None else short(one.bound))),
        line(
            Text(f"{word}; nearest: {one.correction}" if one.correction else word, "bad" if word else "plain")
        ),
    )


def verdict_blocks(result: StageResult) -> Iterator[Block]:
    """Yield one verdict on the stage, in plain words."""
    if result.shown == "analytic" or result.numeric is None:
        return
    yield Heading(2, plain("Verdict"))
    kind, text = _verdict(result)
    yield VerdictLine(kind, plain(text))


def _verdict(result: StageResult) -> tuple[Kind, str]:
    found, numeric = result.verification, result.numeric
    match result.finding:
        case Analysis() as finding:
            exact = _proved(finding)
        case Undecided(_, reason):
            exact = f"undecided exactly ({reason})"
        case None:
            exact = ""
    if not isinstance(found, Verification):
        seen = _numeric_verdict(numeric)
        kind: Kind = "good" if result.is_proved else "open"
        if result.finding is None:
            kind = "info" if isinstance(numeric, NumericFinding) and numeric.rank is not None else "open"
        return kind, "; ".join(part for part in (exact, seen) if part)
    signals = numeric.signals if isinstance(numeric, NumericFinding) else None
    if signals is not None and signals.is_noise and found.verdict != "contradicted":
        return "info", f"{exact}; {_noise(signals, found.n)}"
    return KINDS[found.verdict], f"{exact}; {_compared(found)}"


def _noise(signals: SignalsFinding, n: int) -> str:
    return (
        f"this record excites {signals.excited} of {n} directions: the Gramian shows {signals.shown}, but "
        "noise of the signals explains the rest"
    )


def _proved(finding: Analysis) -> str:
    start = "undecided" if finding.undecided else "proved exactly (generic)"
    if finding.system.sampled and not finding.undecided:
        start = "proved exactly (at generic values of the signals)"
    at = finding.at_values
    if at.rank is None:
        return f"{start}: rank {finding.rank}"
    because = f", because {', '.join(at.because)}" if at.rank != finding.rank and at.because else ""
    return f"{start}: rank {finding.rank}; at your values {at.rank}{because}"


def _numeric_verdict(numeric: NumericFinding | NotComputed | None) -> str:
    match numeric:
        case NotComputed(reason):
            return f"not checked against the Gramian: {reason}"
        case NumericFinding(rank=None):
            return "the Gramian decides the rank at no instant: no gap"
        case NumericFinding(signals=signals) if signals is not None and signals.is_noise:
            return _noise(signals, numeric.system.n)
        case NumericFinding():
            count = sum(p.decided and p.rank == numeric.rank for p in numeric.points)
            return f"the Gramian shows rank {numeric.rank} at {count} of {len(numeric.points)} instants"
    return ""


def _compared(found: Verification) -> str:
    worst = found.worst
    leak = ""
    if worst is not None and worst.chi is not None and worst.bound is not None:
        leak = f", worst leak {short(worst.chi)} (bound {short(worst.bound)})"
    match found.verdict:
        case "verified":
            return f"the Gramian agrees at {found.agree} of {len(found.points)} instants{leak}"
        case "contradicted":
            return f"contradicted by the Gramian: {found.reason}{leak}"
        case "not excited":
            return found.reason
    return f"undecided against the Gramian: {found.reason}{leak}"
