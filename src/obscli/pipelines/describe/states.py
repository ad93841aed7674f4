"""The verdict on each state, by verdict and group, and on each quantity of interest."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from obscli.core.document import Block, Cell, Column, Heading, Table, Text, line, plain
from obscli.exact.finding import Analysis, QuantityVerdict, StateVerdict
from obscli.pipelines.describe.formulas import combination
from obscli.pipelines.describe.words import SIGNS, names, sign


STATE_COLUMNS = (Column(), Column(), Column(align="right"), Column(breaks=True))
QUANTITY_COLUMNS = (Column(), Column("quantity"), Column("verdict"), Column("definition", breaks=True))
PLAIN: Mapping[str, str] = {}

#: What is said of shared states instead of states.
DETERMINED: Mapping[str, str] = {"observable": "determined", "unobservable": "not determined"}
LEGEND = "coupled: known only in combination with the other states of its line."


def state_blocks(finding: Analysis) -> Iterator[Block]:
    """Yield the states in one line a verdict, the coupled ones in one line a group."""
    generic = ", at generic values of the signals" if finding.system.sampled else ""
    yield Heading(2, plain(f"States{generic}"))
    rows = tuple(_verdict_row(finding, verdict) for verdict in SIGNS if verdict in finding.states.values())
    coupled = "coupled" in finding.states.values()
    yield Table(STATE_COLUMNS, rows, (Text(LEGEND, "faint"),) if coupled else ())


def _verdict_row(finding: Analysis, verdict: StateVerdict) -> tuple[Cell, ...]:
    members = tuple(state for state, own in finding.states.items() if own == verdict)
    groups = _coupled_groups(finding, members) if verdict == "coupled" else (members,)
    return (
        line(sign(verdict)),
        line(Text(verdict)),
        line(Text(str(len(members)))),
        tuple(names(group) for group in groups),
    )


def _coupled_groups(finding: Analysis, members: tuple[str, ...]) -> tuple[tuple[str, ...], ...]:
    inside = tuple(tuple(state for state in group if state in members) for group in finding.groups)
    return tuple(group for group in inside if group)


def quantity_blocks(finding: Analysis, words: Mapping[str, str] = PLAIN) -> Iterator[Block]:
    """Yield the verdict on each quantity, where the file names any; ``words``: other words for verdicts."""
    if finding.quantities:
        yield Heading(2, plain("Quantities"))
        yield Table(QUANTITY_COLUMNS, tuple(_quantity_row(one, finding, words) for one in finding.quantities))


def _quantity_row(one: QuantityVerdict, finding: Analysis, words: Mapping[str, str]) -> tuple[Cell, ...]:
    definition = line(combination(one.coefficients, finding.system))
    if one.verdict == "coupled" and one.group:
        definition += ((Text("with ", "faint"), *names(one.group)),)
    verdict = words.get(one.verdict, one.verdict)
    return line(sign(one.verdict)), line(Text(one.name, "name")), line(Text(verdict)), definition
