"""How well an experiment determines what its runs share: deviations before and after, and requirements."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

from obscli.core.document import Block, Cell, Column, Heading, Note, Paragraph, Table, Text, line, plain
from obscli.core.number import short
from obscli.pipelines.calibration_result import CalibrationResult
from obscli.pipelines.describe.words import names, ratio


if TYPE_CHECKING:
    from obscli.experiment.accuracy import Accuracy, Deviation, Required

COLUMNS: Final = (
    Column("state"),
    Column("unit"),
    Column("before", "right"),
    Column("after", "right"),
    Column("best alone", "right"),
    Column("better", "right"),
)
ASKED_COLUMNS: Final = (Column("required", "right"), Column("margin", "right"), Column())
REQUIRED_COLUMNS: Final = (
    Column("required of"),
    Column("unit"),
    Column("at most", "right"),
    Column("before", "right"),
    Column("after", "right"),
    Column("margin", "right"),
    Column(),
)
LEGEND: Final = (
    "one standard deviation, in the units of the file, before the first run and after the last; best alone: "
    "after the best single run; better: how many times."
)
MARGIN: Final = "margin: what is required over what there is after the runs; below 1 it is not met."


def accuracy_blocks(result: CalibrationResult) -> Iterator[Block]:
    """Yield the accuracy, or why there is none where the file asks for it."""
    found = result.accuracy
    if found is None:
        if result.shown is None and (result.model.require or result.experiment.runs[0].system.noise):
            yield Heading(2, plain("Accuracy"))
            yield Note("warning", plain(f"not computed: {result.no_accuracy}"))
        return
    yield Heading(2, plain("Accuracy"))
    asked = {one.name: one for one in found.required}
    rows = [_row(one, asked.pop(one.name, None), asks=bool(found.required)) for one in found.states]
    rows += [_asked_row(one) for one in asked.values()]
    columns = (*COLUMNS, *ASKED_COLUMNS) if found.required else COLUMNS
    legend = f"{LEGEND} {MARGIN}" if found.required else LEGEND
    yield Table(columns, tuple(rows), (Text(legend, "faint"),))
    yield from not_met_blocks(found)
    for note in found.notes:
        yield Note("note", plain(note))


def required_blocks(found: Accuracy) -> Iterator[Block]:
    """Yield the requirements with their margins."""
    if not found.required:
        return
    yield Heading(2, plain("Requirements"))
    yield Table(REQUIRED_COLUMNS, tuple(_required(one) for one in found.required), (Text(MARGIN, "faint"),))
    yield from not_met_blocks(found)


def not_met_blocks(found: Accuracy) -> Iterator[Block]:
    """Yield the requirements that are not met, by name."""
    failed = tuple(one.name for one in found.required if not one.is_met)
    if failed:
        yield Paragraph((Text("Not met: ", "bad"), *names(failed)))


def _row(one: Deviation, asked: Required | None, *, asks: bool) -> tuple[Cell, ...]:
    gain = one.before / one.after if 0 < one.after < float("inf") else 1.0
    cells = (
        line(Text(one.name, "name")),
        line(Text(one.unit, "faint")),
        line(Text(_short(one.before))),
        line(Text(_short(one.after))),
        line(Text(_short(min(one.alone)))),
        line(Text("–" if one.before == one.after else _short(gain))),
    )
    return (*cells, *_margin(asked)) if asks else cells


def _asked_row(one: Required) -> tuple[Cell, ...]:
    """Return the row of a requirement on a quantity."""
    name, before, after = (
        line(Text(one.name, "name")),
        line(Text(_short(one.before))),
        line(Text(_short(one.after))),
    )
    return (
        name,
        line(Text(one.unit, "faint")),
        before,
        after,
        line(Text("–")),
        line(Text("–")),
        *_margin(one),
    )


def _margin(one: Required | None) -> tuple[Cell, ...]:
    if one is None:
        return (line(Text("–")), line(Text("–")), line(Text("")))
    met = Text("✓", "good") if one.is_met else Text("✗", "bad")
    return (line(Text(_short(one.required))), line(Text(ratio(one.margin))), line(met))


def _required(one: Required) -> tuple[Cell, ...]:
    required, margin, met = _margin(one)
    return (
        line(Text(one.name, "name")),
        line(Text(one.unit, "faint")),
        required,
        line(Text(_short(one.before))),
        line(Text(_short(one.after))),
        margin,
        met,
    )


def _short(value: float) -> str:
    return short(value, 3)
