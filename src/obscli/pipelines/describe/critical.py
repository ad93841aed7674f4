"""Parameter values and identities among functions at which the rank drops, and what was not searched."""

from __future__ import annotations

from collections.abc import Iterator

from obscli.core.document import (
    Block,
    Cell,
    Column,
    Details,
    Heading,
    Listing,
    Note,
    Paragraph,
    Table,
    Text,
    line,
    plain,
)
from obscli.exact.finding import Analysis, CriticalSearch, CriticalValue
from obscli.pipelines.describe.formulas import combinations


COLUMNS = (Column("where", breaks=True), Column("rank", align="right"), Column("loses", breaks=True))
APART: dict[str, str] = {
    "excluded": "outside what the file assumes",
    "undefined": "A or H do not exist there",
    "undecided": "undecided",
}


def critical_blocks(finding: Analysis) -> Iterator[Block]:
    """Yield the critical values, those set apart, instants, and how far the search goes."""
    search = finding.critical
    if search is None:
        return
    yield Heading(2, plain("Where the rank drops"))
    yield from _confirmed_blocks(search, finding)
    apart = tuple(one for one in search.values if one.kind != "confirmed")
    if apart:
        yield Listing(tuple(plain(_apart(one)) for one in apart))
    if search.instants:
        yield Note("note", plain(_instants(search.instants)))
    if search.not_searched:
        listed = tuple(plain(f"not searched: {one}") for one in search.not_searched)
        yield Details((Listing(listed),)) if search.complete else Listing(listed)


def _confirmed_blocks(search: CriticalSearch, finding: Analysis) -> Iterator[Block]:
    confirmed = tuple(one for one in search.values if one.kind == "confirmed")
    if confirmed:
        yield Table(COLUMNS, tuple(_row(one, finding) for one in confirmed))
        yield Paragraph((Text(_scope(search), "faint"),))
    else:
        yield Paragraph(plain(f"No critical value found. {_scope(search)}"))


def _row(one: CriticalValue, finding: Analysis) -> tuple[Cell, ...]:
    lost = combinations(one.lost, finding.system) or line(Text("–", "faint"))
    return line(Text(one.condition, "strong")), line(Text("?" if one.rank is None else str(one.rank))), lost


def _scope(search: CriticalSearch) -> str:
    if search.complete:
        return (
            "Complete in codimension one: no other single equation among parameters lowers the rank "
            "(two or more at once were not searched)."
        )
    return "Not complete: other values may exist."


def _instants(instants: tuple[str, ...]) -> str:
    return (
        f"At isolated instants, where {' or '.join(instants)}, the observability matrix itself "
        "has lower rank; on any interval around them nothing is lost."
    )


def _apart(one: CriticalValue) -> str:
    rank = "" if one.rank is None else f" (rank {one.rank})"
    return f"{one.condition}{rank}: {one.reason or APART[one.kind]}"
