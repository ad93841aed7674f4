"""Checks put into words: one line a check, then the count."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Final

from obscli.core.check import CheckResult
from obscli.core.document import Block, Document, Heading, Inline, Kind, Text, VerdictLine, plain
from obscli.pipelines.describe.words import counted
from obscli.pipelines.stage_result import StageChecks


KINDS: Final[dict[str, Kind]] = {"holds": "good", "fails": "bad", "undecided": "open"}


def check_document(results: Iterable[StageChecks]) -> Document:
    """Return all checks, stage by stage, and the summary."""
    results = tuple(results)
    blocks = [block for result in results for block in _stage_blocks(result)]
    checks = [check for result in results for check in result.checks]
    return Document((*blocks, Heading(2, plain("Summary")), _summary(checks)))


def _stage_blocks(result: StageChecks) -> Iterator[Block]:
    yield Heading(2, plain(result.title))
    for check in result.checks:
        yield VerdictLine(KINDS[check.verdict], _sentence(check))


def _sentence(check: CheckResult) -> Inline:
    """Say what holds and in which line it is asserted; of anything else, why, and the whole place."""
    if check.verdict == "holds":
        in_file = check.place is not None and not check.place.file.startswith("--")
        line = f" (line {check.place.line})" if in_file and check.place else ""
        return (Text(check.claim), Text(line, "faint"))
    grounds = f": {check.reason}" if check.reason else ""
    where = "" if check.place is None else f" ({check.place})"
    return (Text(f"{check.verdict}: ", "strong"), Text(check.claim), Text(grounds), Text(where, "faint"))


def _summary(checks: list[CheckResult]) -> Block:
    failed = sum(check.verdict == "fails" for check in checks)
    undecided = sum(check.verdict == "undecided" for check in checks)
    if not failed and not undecided:
        return VerdictLine("good", plain(_all_hold(len(checks))))
    counts = f"{counted(len(checks), 'check')}: {len(checks) - failed - undecided} hold, {failed} failed"
    return VerdictLine("bad" if failed else "open", plain(f"{counts}, {undecided} undecided"))


def _all_hold(count: int) -> str:
    match count:
        case 0:
            return "nothing to check"
        case 1:
            return "1 check, it holds"
    return f"{count} checks, all hold"
