"""The proof of the rank, for those who want to see it."""

from __future__ import annotations

from collections.abc import Iterator

from obscli.core.document import Block, Cell, Column, Details, Heading, Inline, Math, Table, Text, line, plain
from obscli.exact.finding import Analysis, Certificate
from obscli.model.notation import to_text
from obscli.model.system import System
from obscli.pipelines.describe.formulas import direction
from obscli.pipelines.describe.words import names


COLUMNS = (Column(), Column(breaks=True))


def certificate_blocks(finding: Analysis) -> Iterator[Block]:
    """Yield, as details, the two bounds on the generic rank, and on the rank at the file's values."""
    for title, one in (
        ("Certificate of the generic rank", finding.certificate),
        ("Certificate of the rank at the file's values", finding.at_values.certificate),
    ):
        if one is not None:
            yield Details((Heading(2, plain(title)), Table(COLUMNS, _rows(one, finding.system))))


def _rows(one: Certificate, system: System) -> tuple[tuple[Cell, ...], ...]:
    lower, upper = one.lower, one.upper
    taken: Inline = (Text(", ".join(f"{output}^({order})" for output, order in lower.rows)),)
    point = ", ".join(f"{name} = {value}" for name, value in lower.point.items())
    ball = f"{lower.midpoint} ± {lower.radius}, so not zero ({lower.precision} bits)"
    kernel = tuple((direction(vector, system),) for vector in upper.kernel)
    rows: list[tuple[Cell, ...]] = [
        (line(Text(f"rank ≥ {one.rank}")), line(Text("a minor of L whose ball excludes zero"))),
        (line(Text("rows of L")), (taken,)),
        (line(Text("columns")), (names(lower.columns),)),
        (line(Text("at the point")), line(Text(point or "(nothing to choose)"))),
        (line(Text("minor")), line(Text(ball))),
        (
            line(Text(f"rank ≤ {one.rank}")),
            line(Text(f"H N = 0 and {_invariance(system)} exactly, N of full column rank")),
        ),
    ]
    if kernel:
        rows += [(line(Text("columns of N")), kernel), (line(Text("X by columns")), _multiplier(one))]
    if upper.delay is not None:
        text = f"L_k w = 0 for all k < {one.order}, and not for k = {one.order}, so the order is no smaller"
        rows.append((line(Text("w")), ((direction(upper.delay, system),), (Text(text),))))
    assumed = "; ".join(one.assumes) or "nothing beyond the file"
    return (*rows, (line(Text("assumes")), line(Text(assumed))))


def _invariance(system: System) -> str:
    return "F N = N X" if system.discrete else "N′ − A N = N X"


def _multiplier(one: Certificate) -> Cell:
    columns = one.upper.multiplier
    if all(to_text(entry) == "0" for column in columns for entry in column):
        return line(Text("X = 0"))
    return tuple(
        (Math("[" + ", ".join(to_text(entry) for entry in column) + "]", r"\text{see JSON}"),)
        for column in columns
    )
