"""What is analysed where a system is frozen at an instant, and how far that is from the truth."""

from __future__ import annotations

from collections.abc import Iterator

from obscli.core.document import Block, Note, plain
from obscli.pipelines.freezing import Frozen
from obscli.pipelines.stage_result import StageResult


def frozen_blocks(result: StageResult) -> Iterator[Block]:
    """Yield the instant, and a warning where the frozen rank is not the true one."""
    frozen = result.frozen
    if frozen is None:
        return
    when = f"{result.system.time} = {frozen.at}"
    kept = f", {', '.join(frozen.constants)} as constants" if frozen.constants else ""
    yield Note(
        "note", plain(f"A and H are taken as they are at {when}{kept}: all below is about that system")
    )
    if frozen.true_rank is None:
        yield Note("note", plain(f"what the true system is worth is not known: {frozen.reason}"))
    elif frozen.rank is not None:
        yield _compared(frozen)


def _compared(frozen: Frozen) -> Note:
    if frozen.differs:
        text = f"the frozen system has rank {frozen.rank}, the true one {frozen.true_rank}"
        return Note("warning", plain(text))
    return Note("note", plain(f"the true system has the same rank, {frozen.rank}"))
