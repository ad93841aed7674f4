"""The parts of a Kalman decomposition: which states are in each, and which blocks are zero by structure."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from obscli.core.document import Block, Cell, Column, Heading, Table, Text, line, plain
from obscli.pipelines.describe.words import names
from obscli.pipelines.transform_result import Transformed


PART_COLUMNS: Final = (
    Column(align="right"), Column("part"), Column("states", "right"), Column(breaks=True),
)  # fmt: skip
FOUR: Final = (
    "reachable, not observable",
    "reachable, observable",
    "not reachable, not observable",
    "not reachable, observable",
)
TWO: Final = ("observable", "not observable")

#: Ā, B̄ and H̄ by blocks, as they are printed: a dot is a block that is zero by structure.
_FOUR_BLOCKS: Final = (
    ("A11", "A12", "A13", "A14", "B1"),
    ("·", "A22", "·", "A24", "B2"),
    ("·", "·", "A33", "A34", "·"),
    ("·", "·", "·", "A44", "·"),
    ("·", "H2", "·", "H4", ""),
)
_TWO_BLOCKS: Final = (("A11", "·"), ("A21", "A22"), ("H1", "·"))


def part_blocks(found: Transformed) -> Iterator[Block]:
    """Yield the parts with their states, and the pattern of the blocks."""
    four, dynamics = found.by is not None, found.system.dynamics_name
    yield Heading(2, plain("Parts"))
    yield Table(PART_COLUMNS, tuple(_rows(found, FOUR if four else TWO)))
    yield Table(
        tuple(Column(align="centre") for _ in range(5 if four else 2)),
        tuple(
            tuple(_block(name.replace("A", dynamics), found.by) for name in row)
            for row in (_FOUR_BLOCKS if four else _TWO_BLOCKS)
        ),
        (
            Text(
                f"Blocks of {dynamics}, of the input matrix beside it, of H below; a dot is zero by "
                "structure.",
                "faint",
            ),
        ),
    )


def _rows(found: Transformed, titles: tuple[str, ...]) -> Iterator[tuple[Cell, ...]]:
    start = 0
    for k, (title, size) in enumerate(zip(titles, found.sizes, strict=True), 1):
        members = found.system.state_names[start : start + size]
        start += size
        yield line(Text(str(k), "faint")), line(Text(title)), line(Text(str(size))), (names(members),)


def _block(name: str, by: str | None) -> Cell:
    named = name.replace("B", by) if by else name
    return line(Text(named, "faint" if name == "·" else "plain"))
