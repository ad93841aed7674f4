"""The report on segments: what they show together, how much of that is proved, and by which segment."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

from obscli.checks.turned_between import summary
from obscli.core.document import (
    Block,
    Cell,
    Column,
    Heading,
    Note,
    Paragraph,
    Table,
    Text,
    VerdictLine,
    line,
    plain,
)
from obscli.core.number import counted, short
from obscli.core.number import plain as number
from obscli.exact.finding import Analysis, Undecided
from obscli.numeric.finding import NotComputed
from obscli.pipelines.describe.combinations import direction_blocks
from obscli.pipelines.describe.formulas import combination, direction
from obscli.pipelines.describe.signals import taken_as_exact
from obscli.pipelines.describe.states import quantity_blocks, state_blocks
from obscli.pipelines.segments_result import SegmentEnd, SegmentsResult


COLUMNS: Final = (
    Column("#", "right"),
    Column("segment", breaks=True),
    Column("from", "right"),
    Column("to", "right"),
    Column("then"),
    Column("proved", "right"),
    Column("Gramian", "right"),
    Column("gap", "right"),
)
LEGEND: Final = (
    "proved: independent combinations so far, at least, by ball arithmetic at the file's values; Gramian: "
    "its rank at the end of the segment, all before it included; then: whether the state jumps there."
)
COMBINATION_COLUMNS: Final = (Column(align="right"), Column("combination", breaks=True))
DIRECTION_COLUMNS: Final = (Column("#", "right"), Column("hidden all the way", breaks=True))


def segments_blocks(result: SegmentsResult | None) -> Iterator[Block]:
    """Yield the report on the segments of a model, where it has any."""
    if result is None:
        return
    yield Heading(1, (Text(result.title),))
    count = counted(len(result.segments.parts), "segment")
    yield Paragraph(plain(f"{count} one after the other, all {result.n} states carried through"))
    for text in summary(result.turns):
        yield Note("warning", plain(text))
    yield Table(
        COLUMNS, tuple(_row(k, one) for k, one in enumerate(result.ends, 1)), (Text(LEGEND, "faint"),)
    )
    yield from taken_as_exact([one.system for one in result.segments.parts])
    found = result.proved
    if result.rank == result.n:
        yield Paragraph(plain("Every state is observable, and so is every combination."))
    elif found is not None:
        yield from _combinations(found)
        if result.is_at_start:
            yield Note("note", plain("combinations, directions and states are those at the start"))
        yield from direction_blocks(found)
        yield from state_blocks(found)
        yield from quantity_blocks(found)
    else:
        yield from _bounds(result)
    yield from _verdicts(result)


def _row(k: int, one: SegmentEnd) -> tuple[Cell, ...]:
    start, stop = ("–" if math.isnan(t) else number(t) for t in (one.start, one.stop))
    rank = "–" if one.rank is None else f"{one.rank}{'' if one.decided else ' ?'}"
    return (
        line(Text(str(k))),
        line(Text(one.name)),
        line(Text(start)),
        line(Text(stop)),
        line(Text("jump" if one.jumps else "")),
        line(Text("–" if one.proved is None else f"≥ {one.proved}")),
        line(Text(rank, "strong")),
        line(Text(short(one.gap) if one.gap else "–")),
    )


def _combinations(found: Analysis) -> Iterator[Block]:
    """Yield the observable combinations; their coefficients are the same at all times."""
    yield Heading(2, plain(f"Observable combinations ({len(found.combinations)})"))
    rows = tuple(
        (line(Text(str(k), "faint")), line(combination(one.coefficients, found.system)))
        for k, one in enumerate(found.combinations, 1)
    )
    if rows:
        yield Table(COMBINATION_COLUMNS, rows)


def _bounds(result: SegmentsResult) -> Iterator[Block]:
    """Yield the directions that are certainly hidden, where that is all that is known exactly."""
    found = result.there if isinstance(result.there, Analysis) else result.exact
    if isinstance(found, Undecided):
        yield VerdictLine("open", plain(f"undecided: {found.reason}"))
    if isinstance(found, Analysis) and found.unobservable:
        yield Heading(2, plain("Hidden in every segment (proved)"))
        rows = (
            (line(Text(str(k))), line(direction(one, found.system)))
            for k, one in enumerate(found.unobservable, 1)
        )
        yield Table(DIRECTION_COLUMNS, tuple(rows))


def _verdicts(result: SegmentsResult) -> Iterator[Block]:
    n = result.n
    if result.rank is not None:
        where = "generic, and at the file's values" if result.is_generic else "at the file's values"
        stands = ", of the model as it stands: see the warning" if result.turns else ""
        text = f"proved: the segments together show {result.rank} of {n} ({where}){stands}"
        yield VerdictLine("good", plain(text))
    elif result.most is not None and result.least is not None:
        reason = result.certified.reason if result.certified else ""
        bounds = f"at least {result.least} and at most {result.most} of {n} is proved"
        text = f"undecided: {bounds} at the file's values"
        yield VerdictLine("open", plain(f"{text}{': ' + reason if reason else ''}"))
    if isinstance(result.numeric, NotComputed):
        yield VerdictLine("open", plain(f"no Gramian over the segments: {result.numeric.reason}"))
    elif result.numeric is not None:
        yield _of_gramian(result)


def _of_gramian(result: SegmentsResult) -> VerdictLine:
    if result.seen is None:
        return VerdictLine("open", plain("the Gramian over all segments decides no rank at the end: no gap"))
    if result.is_contradicted:
        text = f"the Gramian over all segments has rank {result.seen}, against what is proved"
        return VerdictLine("bad", plain(text))
    if result.rank is not None:
        return VerdictLine("good", plain(f"the Gramian over all segments agrees: rank {result.seen}"))
    text = f"numerical only, not proved: the Gramian over all segments has rank {result.seen} of {result.n}"
    return VerdictLine("info", plain(text))
