"""What an exact substitution (the paper's first step: neglect small terms) changes."""

from __future__ import annotations

from collections.abc import Iterator

from obscli.core.document import Block, Column, Heading, Paragraph, Table, Text, line, plain
from obscli.exact.finding import Analysis, Neglect
from obscli.pipelines.describe.formulas import combinations


COLUMNS = (Column(), Column(breaks=True))


def neglect_blocks(finding: Analysis) -> Iterator[Block]:
    """Yield, for each substitution, the ranks before and after, and the combinations lost and gained."""
    for one in finding.neglect:
        yield Heading(2, plain(f"What {one.substitution} changes"))
        yield Paragraph(plain(_ranks(one)))
        rows = [
            (line(Text(word)), combinations(covectors, finding.system))
            for word, covectors in (("lost", one.lost), ("gained", one.gained))
            if covectors
        ]
        if rows:
            yield Table(COLUMNS, tuple(rows))


def _ranks(one: Neglect) -> str:
    if one.rank_before != one.rank_after:
        return f"The rank goes from {one.rank_before} to {one.rank_after}."
    if one.lost or one.gained:
        return f"The rank stays {one.rank_before}, but the combinations are others."
    return f"Nothing: rank {one.rank_before} and the same observable combinations."
