"""The observable combinations, and the directions no output sees."""

from __future__ import annotations

from collections.abc import Iterator

from obscli.core.document import Block, Column, Heading, Paragraph, Table, Text, line, plain
from obscli.exact.finding import Analysis
from obscli.pipelines.describe.formulas import combination, direction


COMBINATION_COLUMNS = (
    Column(align="right"),
    Column("combination", breaks=True),
    Column("in time"),
    Column("first from"),
    Column("order", align="right"),
)
LEGEND = (
    "constant: keeps its value along every solution; moving: contains moving states. "
    "First from: the output, and the order of its derivative, that first yields it."
)
LEGEND_OF_STEPS = (
    "constant: keeps its value along every solution; moving: contains moving states. "
    "First from: the output, and how many steps later (order) it first yields it."
)


def combination_blocks(finding: Analysis) -> Iterator[Block]:
    """Yield the basis of observable combinations, each with how it moves and where it comes from."""
    yield Heading(2, plain(f"Observable combinations ({len(finding.combinations)})"))
    if not finding.combinations:
        yield Paragraph(plain("None: the outputs say nothing about the states."))
        return
    rows = tuple(
        (
            line(Text(str(k), "faint")),
            line(combination(one.coefficients, finding.system)),
            line(Text("constant") if one.constant else Text("moving", "open")),
            line(Text(one.output, "name")),
            line(Text(str(one.order))),
        )
        for k, one in enumerate(finding.combinations, 1)
    )
    yield Table(
        COMBINATION_COLUMNS, rows, (Text(LEGEND_OF_STEPS if finding.system.discrete else LEGEND, "faint"),)
    )


def direction_blocks(finding: Analysis) -> Iterator[Block]:
    """Yield a basis of the unobservable subspace: changes of the state that no output shows."""
    yield Heading(2, plain(f"Unobservable directions ({len(finding.unobservable)})"))
    if not finding.unobservable:
        yield Paragraph(plain("None: the whole state is observable."))
        return
    rows = tuple(
        (line(Text(str(k), "faint")), line(direction(one, finding.system)))
        for k, one in enumerate(finding.unobservable, 1)
    )
    caption = "Change the states together in these proportions: no output shows it."
    yield Table((Column(align="right"), Column(breaks=True)), rows, (Text(caption, "faint"),))
