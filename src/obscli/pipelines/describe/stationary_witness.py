"""The stationary system as a witness of an analysis, in a line of the verdict."""

from __future__ import annotations

from collections.abc import Iterator

from obscli.core.document import Block, VerdictLine, plain
from obscli.core.number import counted
from obscli.pipelines.stage_result import StageResult


def stationary_witness_blocks(result: StageResult) -> Iterator[Block]:
    """Yield whether a time-invariant system with the same outputs has the same observable combinations."""
    found = result.stationary
    if found is None:
        return
    equations = counted(found.smallest.n, "time-invariant equation")
    if found.agrees:
        count = counted(len(found.combinations), "combination")
        yield VerdictLine("good", plain(f"{equations} with the same outputs have the same {count}"))
    else:
        yield VerdictLine("bad", plain(f"{equations} with the same outputs have other combinations"))
