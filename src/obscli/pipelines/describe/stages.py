"""States × stages: one table that compares what each stage tells about each state."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, Literal

from obscli.core.document import Block, Cell, Column, Heading, Paragraph, Table, Text, line, plain
from obscli.exact.finding import Analysis, LinearFormVerdict
from obscli.numeric.finding import NumericFinding
from obscli.pipelines.describe.signals import excited_rank, not_excited
from obscli.pipelines.describe.words import ALL_SIGNS, SIGNS, sign
from obscli.pipelines.stage_result import StageResult


#: Stage names that together take more cells than this are replaced by numbers explained below the table.
WIDEST_HEADER: Final = 50


def stage_table_blocks(results: tuple[StageResult, ...]) -> Iterator[Block]:
    """Yield the table, where there is more than one stage."""
    if len(results) < 2 or results[0].shown == "verify":
        return
    labels = [result.system.stage or "base" for result in results]
    numbered = sum(len(label) + 2 for label in labels) > WIDEST_HEADER
    titles = [str(k) for k in range(1, len(labels) + 1)] if numbered else labels
    columns = (Column("state"), *(Column(title, "centre") for title in titles))
    shown = [verdict for verdict in ALL_SIGNS if verdict in SIGNS or any(map(not_excited, results))]
    legend = ", ".join(f"{ALL_SIGNS[verdict][0]} {verdict}" for verdict in shown)
    yield Heading(1, plain(f"{results[0].model.name}: states × stages"))
    yield Table(columns, tuple(_rows(results)), (Text(legend, "faint"),))
    if numbered:
        yield Paragraph(plain("Stages: " + ", ".join(f"{k} {label}" for k, label in enumerate(labels, 1))))


def _rows(results: tuple[StageResult, ...]) -> Iterator[tuple[Cell, ...]]:
    states = dict.fromkeys(state for result in results for state in result.system.state_names)
    for state in states:
        yield (line(Text(state, "name")), *(line(_verdict(result, state)) for result in results))
    yield (line(Text("rank", "strong")), *(line(_rank(result)) for result in results))
    excited = [excited_rank(result) for result in results]
    if any(one is not None for one in excited):
        cells = (f"{rank}/{one.system.n}" for rank, one in zip(excited, results, strict=True))
        yield (line(Text("excited", "strong")), *(line(Text(cell)) for cell in cells))


def _verdict(result: StageResult, state: str) -> Text:
    if state in not_excited(result):
        return sign("not excited")
    match result.finding, result.numeric:
        case Analysis(states=states), _:
            verdict: LinearFormVerdict | Literal["not excited"] | None = states.get(state)
        case None, NumericFinding(states=seen) if seen:
            verdict = seen.get(state)
        case _:
            return Text("?", "open")
    return Text("") if verdict is None else sign(verdict)


def _rank(result: StageResult) -> Text:
    found = result.finding if result.finding is not None else result.numeric
    rank = found.rank if isinstance(found, Analysis | NumericFinding) else None
    return Text("?" if rank is None else f"{rank}/{result.system.n}")
