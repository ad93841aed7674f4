"""The ranks: generic with its proof, at the file's values with its reason, frozen with a warning."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from obscli.core.document import Block, Column, Inline, Note, Table, Text, VerdictLine, plain
from obscli.core.number import short
from obscli.exact.finding import Analysis, AtValues, Measure, NearMiss


COLUMNS = (Column(), Column(align="right"), Column(breaks=True))
MEASURES: Final[dict[Measure, str]] = {
    "value": "its value",
    "unit": "the largest value of the same unit",
    "rate": "the fastest other rate",
}


def rank_blocks(finding: Analysis) -> Iterator[Block]:
    """Yield the table of ranks, what is undecided about them, the warning about the frozen one, and notes."""
    rows = [_generic(finding), _at_values(finding)]
    if finding.frozen_rank is not None:
        rows.append(_frozen(finding))
    yield Table(COLUMNS, tuple(tuple((content,) for content in row) for row in rows))
    for reason in finding.undecided:
        yield VerdictLine("open", plain(f"undecided: {reason}"))
    if finding.frozen_rank not in (None, finding.rank):
        yield Note("warning", plain(_warning(finding)))
    for note in finding.notes:
        yield Note("note", plain(note))


def _generic(finding: Analysis) -> tuple[Inline, ...]:
    proof = (Text("undecided", "open"),) if finding.undecided else (Text("proved (generic)", "good"),)
    reached = f"of {finding.system.n}, reached at L_{finding.order}; "
    return plain("generic rank"), (Text(str(finding.rank), "strong"),), (Text(reached), *proof)


def _at_values(finding: Analysis) -> tuple[Inline, ...]:
    at = finding.at_values
    label = plain("at the file's values")
    if at.rank is None:
        return label, plain("?"), plain(at.reason or "not computed")
    grounds = ", ".join(at.because) or at.reason
    nearly = _nearly(at)
    if at.rank == finding.rank:
        same = f"the same{': ' + grounds if grounds else ''}"
        return label, plain(str(at.rank)), (Text(same), *nearly)
    return (
        label,
        (Text(str(at.rank), "strong"),),
        (Text("because ", "open"), Text(grounds or "of these values"), *nearly),
    )


def _nearly(at: AtValues) -> Inline:
    """Say which conditions the values miss by little, those of one rank together."""
    content: list[Text] = []
    for rank in sorted({one.rank for one in at.nearly}):
        missed = ", ".join(_missed(one) for one in at.nearly if one.rank == rank)
        content += [Text(f"; nearly {rank}: ", "open"), Text(missed)]
    return tuple(content)


def _missed(one: NearMiss) -> str:
    return f"{one.condition} is missed by {short(one.distance)} of {MEASURES[one.measure]}"


def _frozen(finding: Analysis) -> tuple[Inline, ...]:
    return (
        plain("frozen system"),
        plain(str(finding.frozen_rank)),
        plain(
            "A, H at a fixed t taken as constant"
            if finding.varying
            else f"the same: {finding.system.dynamics_name}, H do not vary"
        ),
    )


def _warning(finding: Analysis) -> str:
    return f"most tools compute the frozen rank; this system's is {finding.rank}, not {finding.frozen_rank}"
