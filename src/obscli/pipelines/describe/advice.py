"""What to do now."""

from __future__ import annotations

from collections.abc import Iterator

from obscli.core.document import Block, Heading, Listing, plain
from obscli.exact.finding import Analysis


def advice_blocks(finding: Analysis) -> Iterator[Block]:
    """Yield the advice of the analysis, most useful first."""
    if finding.advice:
        yield Heading(2, plain("What to do"))
        yield Listing(tuple(plain(one) for one in finding.advice), numbered=len(finding.advice) > 1)
