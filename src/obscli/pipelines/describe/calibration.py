"""The report on an experiment: what is shared, what each run and all together determine, how well."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Final

from obscli.core.document import (
    Block,
    Cell,
    Column,
    Details,
    Document,
    Heading,
    Inline,
    Listing,
    Paragraph,
    Table,
    Text,
    VerdictLine,
    line,
    plain,
)
from obscli.core.number import counted
from obscli.core.number import plain as number
from obscli.exact.finding import Analysis, Undecided
from obscli.experiment.special import Special
from obscli.model.system import System
from obscli.numeric.finding import NumericFinding
from obscli.pipelines.calibration_result import CalibrationResult, RunResult
from obscli.pipelines.describe.accuracy import accuracy_blocks
from obscli.pipelines.describe.calibration_verdict import calibration_verdict_blocks
from obscli.pipelines.describe.formulas import combination, combinations, direction
from obscli.pipelines.describe.shared import default_note, interval_note, shared_blocks
from obscli.pipelines.describe.states import DETERMINED, quantity_blocks
from obscli.pipelines.describe.words import SIGNS, UNDECIDED, sign


FACT_COLUMNS: Final = (Column(), Column(breaks=True))
RUN_COLUMNS: Final = (
    Column("#", "right"),
    Column("run", breaks=True),
    Column("time"),
    Column("rank", "right"),
    Column("rows of M", "right"),
    Column("adds", "right"),
)
RUN_LEGEND: Final = (
    "rank: of the run by itself, over all states; rows of M: combinations of shared states alone that it "
    "determines; adds: how many of them the runs before it do not."
)
ROW_COLUMNS: Final = (Column("#", "right"), Column("determines", breaks=True))
RANK_COLUMNS: Final = (Column(), Column(align="right"), Column(breaks=True))
DROP_COLUMNS: Final = (
    Column("where", breaks=True),
    Column("rank", align="right"),
    Column("no longer determined", breaks=True),
)

#: Signs of so many runs stand together.
GROUPED: Final = 6


def calibration_document(results: Iterable[CalibrationResult]) -> Document:
    """Return the report on experiments."""
    return Document(tuple(block for result in results for block in _blocks(result)))


def _blocks(result: CalibrationResult) -> Iterator[Block]:
    yield Heading(1, (Text(result.title),))
    if result.model.title:
        yield Paragraph((Text(result.model.title, "strong"),))
    yield from shared_blocks(result.exact.shared, result.exact.fresh, result.exact.own)
    if result.experiment.description:
        yield Paragraph(plain(result.experiment.description))
    yield from default_note(result.is_default)
    yield from _run_blocks(result)
    finding = result.exact.stack.finding
    if isinstance(finding, Undecided):
        yield VerdictLine("open", plain(f"undecided: {finding.reason}"))
    else:
        yield from _together_blocks(result, finding)
        yield from _constant_blocks(result, finding)
        yield from _missing_blocks(finding)
        yield from quantity_blocks(finding, DETERMINED)
        yield from _special_blocks(result.exact.special, result.exact.stack.system)
    yield from accuracy_blocks(result)
    yield from calibration_verdict_blocks(result)


def _run_blocks(result: CalibrationResult) -> Iterator[Block]:
    yield Heading(2, plain(f"Runs ({len(result.runs)})"))
    adds = result.exact.stack.adds
    known = isinstance(result.exact.stack.finding, Analysis)
    rows = tuple(
        _run_row(k, one, len(adds[k - 1]) if known else None) for k, one in enumerate(result.runs, start=1)
    )
    yield Table(RUN_COLUMNS, rows, (Text(RUN_LEGEND, "faint"),))
    by_default = [
        r.run.name for r in result.runs if isinstance(r.numeric, NumericFinding) and r.numeric.default
    ]
    yield from interval_note(by_default)
    yield Heading(2, plain("What each run determines"))
    yield Table(ROW_COLUMNS, tuple(_determines(result)))


def _run_row(k: int, one: RunResult, adds: int | None) -> tuple[Cell, ...]:
    finding, lasts = one.rows.finding, one.lasts
    rank = str(finding.rank) if isinstance(finding, Analysis) else "?"
    return (
        line(Text(str(k), "faint")),
        line(Text(one.run.name, "name")),
        line(Text("–" if lasts is None else f"{number(lasts[0])} … {number(lasts[1])}")),
        line(Text(f"{rank} of {one.run.system.n}")),
        line(Text("?" if one.rows.undecided else str(len(one.rows.rows)))),
        line(Text("?" if adds is None else str(adds))),
    )


def _determines(result: CalibrationResult) -> Iterator[tuple[Cell, ...]]:
    """Yield the rows M_i of every run; runs that determine the same stand together."""
    system = result.exact.stack.system
    cells: dict[tuple[str, ...], tuple[list[str], Cell]] = {}
    for k, one in enumerate(result.runs, start=1):
        cell = combinations(one.rows.rows, system) or line(Text(one.rows.undecided or "nothing", "faint"))
        key = tuple(str(inline) for inline in cell)
        cells.setdefault(key, ([], cell))[0].append(str(k))
    for numbers, cell in cells.values():
        yield line(Text(" ".join(numbers), "faint")), cell


def _together_blocks(result: CalibrationResult, finding: Analysis) -> Iterator[Block]:
    exact = result.exact
    stack, there = exact.stack, exact.at_file
    n = len(exact.shared)
    yield Heading(2, plain("All runs together"))
    matrix = f"{stack.system.m} × {n}, a reduced basis of each run below the other"
    proof = (Text(f"of {n}; "), Text("proved (generic)", "good"))
    rows: list[tuple[Inline, Inline, Inline]] = [
        (plain("matrix M"), (), plain(matrix)),
        (plain("generic rank"), (Text(str(finding.rank), "strong"),), proof),
    ]
    if there.rank is None:
        rows.append((plain("at the file's values"), plain("?"), plain(there.reason)))
    elif there.rank == finding.rank:
        rows.append((plain("at the file's values"), plain(str(there.rank)), plain("the same")))
    else:
        because = f"because {', '.join(there.because)}" if there.because else "because of these values"
        rows.append((plain("at the file's values"), (Text(str(there.rank), "strong"),), plain(because)))
    yield Table(RANK_COLUMNS, tuple(tuple((content,) for content in row) for row in rows))


def _constant_blocks(result: CalibrationResult, finding: Analysis) -> Iterator[Block]:
    """Yield constants × runs: what each run says of each shared state, and all together."""
    yield Heading(2, plain("Shared states × runs"))
    count = len(result.runs)
    title = "run 1" if count == 1 else f"runs 1 … {count}"
    columns = (Column("state"), Column(title), Column("together", "centre"))
    rows = tuple(
        (line(Text(state, "name")), (_signs(result, state),), line(sign(finding.states[state])))
        for state in result.exact.shared
    )
    legend = ", ".join(f"{mark} {word}" for (mark, _), word in zip(SIGNS.values(), WORDS, strict=True))
    yield Table(columns, rows, (Text(legend, "faint"),))


WORDS: Final = ("determined", "only in combination", "in no combination of shared states")


def _signs(result: CalibrationResult, state: str) -> Inline:
    content: list[Text] = []
    for k, one in enumerate(result.runs):
        verdict = one.verdict(state)
        gap = "" if not k else " " if k % GROUPED else "  "
        content += [Text(gap), Text(*UNDECIDED) if verdict is None else sign(verdict)]
    return tuple(content[1:])


def _missing_blocks(finding: Analysis) -> Iterator[Block]:
    """Yield what is known only in combination, and along which directions nothing is known."""
    coupled = tuple(one for one in finding.combinations if len(one.coefficients) > 1)
    if coupled:
        yield Heading(2, plain(f"Determined only in combination ({len(coupled)})"))
        yield Listing(tuple((combination(one.coefficients, finding.system),) for one in coupled))
    if finding.unobservable:
        yield Heading(2, plain(f"Not determined ({counted(len(finding.unobservable), 'direction')})"))
        rows = tuple(
            (line(Text(str(k), "faint")), line(direction(one, finding.system)))
            for k, one in enumerate(finding.unobservable, 1)
        )
        caption = "Change the shared states together in these proportions: no run shows it."
        yield Table((Column(align="right"), Column(breaks=True)), rows, (Text(caption, "faint"),))


def _special_blocks(special: Special | None, system: System) -> Iterator[Block]:
    if special is None:
        return
    yield Heading(2, plain("Where the experiment determines less"))
    confirmed = tuple(one for one in special.drops if one.kind == "confirmed")
    if confirmed:
        rows = tuple(
            (
                line(Text(one.condition, "strong")),
                line(Text("?" if one.rank is None else str(one.rank))),
                combinations(one.lost, system) or line(Text("–", "faint")),
            )
            for one in confirmed
        )
        yield Table(DROP_COLUMNS, rows)
    scope = (
        "Complete in codimension one: no other single equation among parameters costs rank."
        if special.complete
        else "Not complete: other values may exist."
    )
    apart = tuple(one for one in special.drops if one.kind != "confirmed")
    none = "No such value is proved." if apart else "No such value found."
    yield Paragraph(plain(scope if confirmed else f"{none} {scope}"))
    if apart:
        yield Listing(tuple(plain(f"{one.condition}: {one.reason or one.kind}") for one in apart))
    if special.not_searched:
        listed = Listing(tuple(plain(f"not searched: {one}") for one in special.not_searched))
        yield Details((listed,)) if special.complete else listed
