"""Checks put into words: one line a check, what is wrong where one fails, then the count."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Final

from obscli.core.check import Change, CheckResult, Counterexample
from obscli.core.document import (
    Block,
    Column,
    Details,
    Document,
    Heading,
    Inline,
    Kind,
    Note,
    Table,
    Text,
    VerdictLine,
    line,
    plain,
)
from obscli.core.number import counted, short
from obscli.pipelines.describe.verification import comparison_blocks
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
        yield from _what_is_wrong(check)
        if check.verification is not None and check.verdict == "fails":
            yield from comparison_blocks(check.verification)
        if check.transformation:
            yield Details((_transformation(check),))


def _sentence(check: CheckResult) -> Inline:
    """Say what holds and in which line it is asserted; of anything else, why, and the whole place."""
    if check.verdict == "holds":
        return (Text(check.claim), Text(_grounds(check), "faint"))
    grounds = f": {check.reason}" if check.reason else ""
    where = "" if check.place is None else f" ({check.place})"
    return (Text(f"{check.verdict}: ", "strong"), Text(check.claim), Text(grounds), Text(where, "faint"))


def _grounds(check: CheckResult) -> str:
    """Return the line where it is said, and how far the Gramian agrees."""
    parts = []
    if check.place is not None and not check.place.file.startswith("--"):
        parts.append(f"line {check.place.line}")
    if check.transformation:
        parts.append("equivalent: another basis of the same space")
    seen = check.gramian
    if seen is not None:
        leak = f", χ ≤ {short(seen.chi)}" if seen.chi else ""
        parts.append(f"Gramian {seen.agree} of {seen.of}{leak}")
    return f" ({'; '.join(parts)})" if parts else ""


def _what_is_wrong(check: CheckResult) -> Iterator[Block]:
    """Yield what would be right, and what the claim gets wrong, in words."""
    for of in dict.fromkeys(change.of for change in check.corrections):
        yield Note("note", plain(_corrected([change for change in check.corrections if change.of == of])))
    one = check.counterexample
    if one is None:
        return
    if not check.corrections:
        yield Note("note", plain("no correction of at most three coefficients was found"))
    yield Note("note", plain(_told_apart(one)))


def _corrected(changes: list[Change]) -> str:
    """Return what one combination gets wrong, and the nearest observable ones: equally small changes."""
    several = "s" if len(changes) > 1 else ""
    words = ", or ".join(one.words for one in changes)
    nearest = ", or ".join(one.corrected for one in changes)
    return f"{changes[0].of} {words}; nearest observable combination{several}: {nearest}"


def _told_apart(one: Counterexample) -> str:
    """Return the two trajectories that no output tells apart."""
    direction = ", ".join(f"{state}: {entry}" for state, entry in one.direction.items())
    if one.is_trajectory:
        pair = f"x(t) and x(t) + ({direction}) give the same outputs for ever"
    else:
        pair = f"two trajectories that differ by ({direction}) at some instant give the same outputs for ever"
    found = one.trajectories
    seen = "" if found is None else f" (computed: outputs alike to {short(max(found.output, 1e-16))})"
    return f"{pair}{seen}; the claim says they differ by {one.claim}"


def _transformation(check: CheckResult) -> Table:
    """Return T(t): the claimed basis = T · proved basis."""
    rows = tuple(
        (line(Text(str(k), "faint")), line(Text(" + ".join(_terms(row)).replace("+ -", "- "))))
        for k, row in enumerate(check.transformation, 1)
    )
    caption = "The claimed rows by those of the proved basis (s1, s2, … in the order of `obscli analyze`)."
    return Table((Column(align="right"), Column("claimed row", breaks=True)), rows, (Text(caption, "faint"),))


def _terms(row: tuple[str, ...]) -> Iterator[str]:
    for k, entry in enumerate(row, 1):
        if entry in {"1", "-1"}:
            yield f"{entry[:-1]}s{k}"
        elif entry != "0":
            yield f"({entry})*s{k}" if " " in entry else f"{entry}*s{k}"


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
