"""The report on orders of segments: the shortest ones, and what each segment in them adds."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from obscli.core.document import (
    Block,
    Column,
    Document,
    Heading,
    Note,
    Paragraph,
    Table,
    Text,
    VerdictLine,
    line,
    plain,
)
from obscli.core.number import counted
from obscli.core.number import plain as number
from obscli.pipelines.plan_segments import SegmentPlan


COLUMNS: Final = (
    Column("#", "right"),
    Column("order", breaks=True),
    Column("time", "right"),
    Column("after each", breaks=True),
)
LEGEND: Final = (
    "after each: independent combinations so far, at least, proved by ball arithmetic at the file's values. "
    "A segment that is moved brings its own time along."
)


def orders_document(plan: SegmentPlan) -> Document:
    """Return the report."""
    return Document(tuple(_blocks(plan)))


def _blocks(plan: SegmentPlan) -> Iterator[Block]:
    found = plan.found
    yield Heading(1, (Text(plan.title),))
    yield Paragraph(plain(f"The file's own order shows {found.target} of {plan.n}, at least"))
    rows = tuple(
        (
            line(Text(str(k))),
            line(Text(", ".join(one.names))),
            line(Text(number(one.duration))),
            line(Text(" ".join(map(str, one.after)))),
        )
        for k, one in enumerate(found.best, 1)
    )
    yield Table(COLUMNS, rows, (Text(LEGEND, "faint"),))
    if not found.is_complete:
        yield Note("warning", plain(f"only {found.tried} orders were tried: longer ones may show more"))
    if found.best:
        count = counted(len(found.best[0].names), "segment")
        text = f"proved: {found.rank} of {plan.n} are shown by {count} in this order"
        yield VerdictLine("good" if found.rank >= found.target else "open", plain(text))
        yield Note("note", plain("no shorter order was seen to show as much; that none does is not proved"))
