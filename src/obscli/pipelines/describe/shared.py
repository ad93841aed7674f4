"""Which states the runs of an experiment share: the first thing to check in a report about it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

from obscli.core.document import Block, Column, Note, Table, Text, line, plain
from obscli.experiment.own_symbols import OwnSymbol
from obscli.pipelines.describe.words import names


COLUMNS: Final = (Column(), Column(breaks=True))
LEGEND: Final = "shared: constant, one value in all runs; fresh: starts anew in every run and is eliminated."


def shared_blocks(
    shared: tuple[str, ...], fresh: tuple[str, ...], own: Sequence[OwnSymbol]
) -> Iterator[Block]:
    """Yield the states that are shared, those that are not, and parameters told apart by their values."""
    rows = [(line(Text(f"shared ({len(shared)})", "strong")), (names(shared) or plain("none"),))]
    if fresh:
        rows.append((line(Text(f"fresh ({len(fresh)})")), (names(fresh),)))
    yield Table(COLUMNS, tuple(rows), (Text(LEGEND, "faint"),))
    for one in own:
        yield Note("note", plain(f"{one.name} stands for {one.of} = {one.value} in {', '.join(one.runs)}"))


def default_note(is_default: bool) -> Iterator[Block]:  # noqa: FBT001 - the one thing asked
    """Yield the remark that the file has no experiment of its own."""
    if is_default:
        yield Note("note", plain("the file has no `experiment`: every stage counts as a run"))


def interval_note(runs: Sequence[str]) -> Iterator[Block]:
    """Yield the remark that the intervals of some runs are not the file's."""
    if runs:
        default = "what the files of signals cover is taken, else 20 over the fastest rate"
        text = f"the file gives no `interval` ({default}) for "
        yield Note("warning", plain(f"{text}{', '.join(runs)}: durations and deviations rest on that"))
