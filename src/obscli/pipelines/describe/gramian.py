"""The numerical side: how the Gramian was found, its rank over time, and what that rests on."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from obscli.core.document import (
    Block,
    Cell,
    Column,
    Details,
    Heading,
    Inline,
    Note,
    Paragraph,
    Table,
    Text,
    VerdictLine,
    line,
    plain,
)
from obscli.core.number import plain as number
from obscli.core.number import short
from obscli.model.system import System
from obscli.numeric.finding import NotComputed, NumericFinding, NumericPoint
from obscli.pipelines.describe.instants import runs, span
from obscli.pipelines.describe.words import ALL_SIGNS, names
from obscli.pipelines.stage_result import StageResult


FACT_COLUMNS: Final = (Column(), Column(breaks=True))
POINT_COLUMNS: Final = (
    Column("t"),
    Column("rank", "right"),
    Column("kernel q", "right"),
    Column("gap", "right"),
    Column("least kept", "right"),
    Column("tolerance", "right"),
    Column(),
)
METHODS: Final = {
    "square-root": "square root, carried from step to step by QR",
    "lyapunov": "equation (3) integrated with DOP853: singular values are roots of those of W",
    "quadrature": "definition (2) summed: singular values are roots of those of W",
    "lift": "square root, through a stationary system with the same outputs by matrix exponentials",
}
SCALINGS: Final = {
    "automatic": "automatic: every state in units in which its column of the factor has length 1",
    "scale": "the file's `scale` of the states",
    "prior": "the initial standard deviations of the file (P0)",
    "none": "none: the units of the file",
}
LEGEND: Final = (
    "gap: the least singular value kept over the largest one dropped, or over the noise if that is larger. "
    "Least kept, tolerance: singular values of the square root of the Gramian in scaled units."
)


def gramian_blocks(result: StageResult) -> Iterator[Block]:
    """Yield how the Gramian was found, and its rank over time where nothing else shows it."""
    found = result.numeric
    if found is None:
        return
    yield Heading(2, plain("Gramian"))
    if isinstance(found, NotComputed):
        yield VerdictLine("open", plain(f"not computed: {found.reason}"))
        return
    yield Table(FACT_COLUMNS, tuple(_facts(found)))
    if found.window is not None:
        yield Note("note", plain(_shortened(short(found.window), found.system)))
    table = Table(POINT_COLUMNS, tuple(_rows(found)), (Text(LEGEND, "faint"),))
    yield table if result.shown == "numeric" else Details((table,))
    every = Table(POINT_COLUMNS, tuple(_row(found, (point,)) for point in found.points))
    yield Details((Paragraph(plain("At every instant:")), every))


def _shortened(window: str, system: System) -> str:
    """Say that windows are shorter than the interval, and why."""
    if system.discrete:
        return f"windows shortened, down to the next {window} steps: growth hides the rest over the interval"
    return (
        f"windows shortened, down to the last {window} before an instant: over the whole "
        "interval fast decay drowns the rest, or takes too many steps; the row space is the same"
    )


def _facts(found: NumericFinding) -> Iterator[tuple[Cell, ...]]:
    count = len(found.points)
    first, last = number(found.points[0].t), number(found.points[-1].t)
    if found.system.discrete:
        yield from _discrete_facts(found)
    else:
        ends = f"{first if first == last else f'{first} to {last}'}, from t0 = {number(found.start)}"
        taken = "20 over the fastest rate" if found.signals is None else "all that the files of signals cover"
        default = f" (default interval: {taken})" if found.default else ""
        step_error = f"step error {short(found.rtol)}" if found.rtol else "no step error"
        yield line(Text("method")), line(Text(f"{METHODS[found.method]}; {step_error}"))
        yield line(Text("instants")), line(Text(f"{count}: {ends}{default}"))
    yield line(Text("scaling")), line(Text(SCALINGS[found.scaling]))
    if found.sampled:
        yield line(Text("motion")), (_sampled(found),)
    yield line(Text("rank")), (_rank(found),)


def _discrete_facts(found: NumericFinding) -> Iterator[tuple[Cell, ...]]:
    """Yield how the Gramian of a discrete-time system was found, and at which steps."""
    points, time = found.points, found.system.time
    first, last = number(points[0].t), number(points[-1].t)
    ends = first if first == last else f"{first} to {last}"
    stop = number(max(point.stop or 0.0 for point in points))
    default = " (default interval)" if found.default else ""
    yield line(Text("method")), line(Text("square root, carried back from sample to sample by QR"))
    words = f"{len(points)}: {time} = {ends}, each with the outputs from there to {time} = {stop}{default}"
    yield line(Text("steps")), line(Text(words))


def _sampled(found: NumericFinding) -> Inline:
    return (Text("one sample motion for "), *names(found.sampled))


def _rank(found: NumericFinding) -> Inline:
    n, count = found.system.n, len(found.points)
    if found.rank is None:
        return (Text("undecided at every instant: no gap", "open"),)
    agree = [p for p in found.points if p.decided and p.rank == found.rank]
    gaps = [p.gap for p in agree if p.gap is not None]
    gap = f", gap at least {short(min(gaps))}" if gaps else ""
    return (
        Text(str(found.rank), "strong"),
        Text(f" of {n} at {len(agree)} of {count} instants{gap}; tolerance {_tolerances(agree)}"),
    )


def _tolerances(points: list[NumericPoint]) -> str:
    low, high = min(p.tolerance for p in points), max(p.tolerance for p in points)
    return short(low) if high <= 1.5 * low else f"{short(low)} to {short(high)}"


def _rows(found: NumericFinding) -> Iterator[tuple[Cell, ...]]:
    for run in runs(found.points, lambda point: (point.rank, point.decided)):
        yield _row(found, run)


def _row(found: NumericFinding, run: tuple[NumericPoint, ...]) -> tuple[Cell, ...]:
    first = run[0]
    gaps = [p.gap for p in run if p.gap is not None]
    kept = [p.weakest for p in run if p.weakest is not None]
    return (
        line(Text(span(run))),
        line(Text(str(first.rank), "strong")),
        line(Text(str(found.system.n - first.rank))),
        line(Text(short(min(gaps)) if gaps else "–")),
        line(Text(short(min(kept)) if kept else "–")),
        line(Text(short(max(p.tolerance for p in run)))),
        line(Text("", "good") if first.decided else Text("undecided: no gap", "open")),
    )


def gramian_state_blocks(result: StageResult) -> Iterator[Block]:
    """Yield the states as the Gramian shows them, where nothing else says it."""
    found = result.numeric
    if result.shown != "numeric" or not isinstance(found, NumericFinding) or not found.states:
        return
    yield Heading(2, plain("States, as the Gramian shows them"))
    rows = []
    for verdict, (mark, role) in ALL_SIGNS.items():
        members = tuple(state for state, own in found.states.items() if own == verdict)
        if members:
            groups = found.groups if verdict == "coupled" else (members,)
            cells: Cell = tuple(names(group) for group in groups)
            rows.append((line(Text(mark, role)), line(Text(verdict)), line(Text(str(len(members)))), cells))
    yield Table((Column(), Column(), Column(align="right"), Column(breaks=True)), tuple(rows))
