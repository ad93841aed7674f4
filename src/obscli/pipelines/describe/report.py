"""The whole report: stage after stage, then the table that compares them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from obscli.core.document import Block, Document, Heading, Inline, Paragraph, Table, Text, VerdictLine, plain
from obscli.exact.finding import Analysis, Undecided
from obscli.pipelines.describe.advice import advice_blocks
from obscli.pipelines.describe.certificate import certificate_blocks
from obscli.pipelines.describe.certified import certified_blocks
from obscli.pipelines.describe.combinations import combination_blocks, direction_blocks
from obscli.pipelines.describe.critical import critical_blocks
from obscli.pipelines.describe.dual import dual_blocks, told_of
from obscli.pipelines.describe.frozen import frozen_blocks
from obscli.pipelines.describe.gramian import gramian_blocks, gramian_state_blocks
from obscli.pipelines.describe.neglect import neglect_blocks
from obscli.pipelines.describe.ranks import rank_blocks
from obscli.pipelines.describe.signals import signal_blocks
from obscli.pipelines.describe.stages import stage_table_blocks
from obscli.pipelines.describe.states import quantity_blocks, state_blocks
from obscli.pipelines.describe.stationary_witness import stationary_witness_blocks
from obscli.pipelines.describe.structure import structure_blocks
from obscli.pipelines.describe.summary import summary_blocks
from obscli.pipelines.describe.time_basis import time_basis_blocks
from obscli.pipelines.describe.verification import verdict_blocks, verification_blocks
from obscli.pipelines.stage_result import StageResult


#: The sections on the exact finding, in the order the reader meets them.
SECTIONS = (
    rank_blocks,
    combination_blocks,
    direction_blocks,
    state_blocks,
    quantity_blocks,
    critical_blocks,
    neglect_blocks,
    advice_blocks,
    certificate_blocks,
)

#: The sections on the structure, the numerical side and on the comparison of the two, after those.
SECTIONS_AFTER = (
    structure_blocks,
    gramian_blocks,
    signal_blocks,
    gramian_state_blocks,
    time_basis_blocks,
    verification_blocks,
    certified_blocks,
    verdict_blocks,
    stationary_witness_blocks,
)


def report_document(results: Iterable[StageResult]) -> Document:
    """Return the report on the stages of one model."""
    results = tuple(results)
    blocks = [block for result in results for block in _stage_blocks(result, first=result is results[0])]
    table = () if any(result.shown == "structure" for result in results) else stage_table_blocks(results)
    return Document((*_explained_once(blocks), *table))


def _stage_blocks(result: StageResult, *, first: bool) -> Iterable[Block]:
    yield Heading(1, (Text(result.title),))
    if first and result.model.title:
        yield Paragraph((Text(result.model.title, "strong"),))
    yield from dual_blocks(result.system)
    yield from told_of(result.system, _sections(result))


def _sections(result: StageResult) -> Iterable[Block]:
    yield from summary_blocks(result)
    yield from frozen_blocks(result)
    match result.finding:
        case Undecided(_, reason):
            yield VerdictLine("open", plain(f"undecided: {reason}"))
        case Analysis() as finding if result.shown not in {"verify", "structure"}:
            for section in SECTIONS:
                yield from section(finding)
    for after in SECTIONS_AFTER:
        yield from after(result)


def _explained_once(blocks: Iterable[Block]) -> Iterable[Block]:
    """Keep the caption that explains a table under the first such table only."""
    said: set[Inline] = set()
    for block in blocks:
        if isinstance(block, Table):
            yield replace(block, caption=()) if block.caption in said else block
            said.add(block.caption)
        else:
            yield block
