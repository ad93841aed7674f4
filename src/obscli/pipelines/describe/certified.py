"""The certified rank of the Gramian: its proof at every instant, or why there is none."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from obscli.checks.certified_rank import CertifiedInstant
from obscli.core.document import (
    Block,
    Cell,
    Column,
    Heading,
    Paragraph,
    Table,
    Text,
    VerdictLine,
    line,
    plain,
)
from obscli.core.number import plain as number
from obscli.pipelines.stage_result import StageResult


COLUMNS: Final = (
    Column("t"),
    Column("rank", "right"),
    Column("a minor of sampled output rows", breaks=True),
    Column("bits", "right"),
    Column("samples", "right"),
)
LEGEND: Final = (
    "The minor is a ball that excludes zero: the rank is not lower. The kernel is exact: it is not higher."
)


def certified_blocks(result: StageResult) -> Iterator[Block]:
    """Yield the proved rank of W(t, t0) at each instant, where it was asked for."""
    found = result.certified
    if found is None:
        return
    yield Heading(2, plain("Certified rank"))
    if found.reason:
        yield VerdictLine("open", plain(f"no certified rank: {found.reason}"))
        return
    text = f"rank W(t, t0) at the file's values, t0 = {number(found.start)}, proved in ball arithmetic:"
    yield Paragraph(plain(text))
    yield Table(COLUMNS, tuple(_row(one) for one in found.instants), (Text(LEGEND, "faint"),))


def _row(one: CertifiedInstant) -> tuple[Cell, ...]:
    t = line(Text(number(one.t)))
    if one.rank is None:
        return t, line(Text("?", "open")), line(Text(f"undecided: {one.reason}", "open")), line(), line()
    rank = line(Text(str(one.rank), "good"))
    if one.minor is None:
        return t, rank, line(Text("none needed")), line(), line()
    minor = one.minor
    return (
        t,
        rank,
        line(Text(f"{minor.midpoint} ± {minor.radius}")),
        line(Text(str(minor.precision))),
        line(Text(str(minor.samples))),
    )
