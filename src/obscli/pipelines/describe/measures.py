"""Measures of observability as tables: states down, measures across, and how each is read."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
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
    Math,
    Paragraph,
    Table,
    Text,
    VerdictLine,
    line,
    plain,
)
from obscli.core.number import plain as number
from obscli.core.number import short
from obscli.exact.finding import Undecided
from obscli.measures.measure import Direction, Found, Measure
from obscli.measures.subject import Target
from obscli.model.expression import symbols
from obscli.model.notation import to_latex, to_text
from obscli.numeric.finding import NotComputed
from obscli.pipelines.describe.formulas import combination
from obscli.pipelines.describe.measures_notes import limit_blocks, note_blocks, reading_blocks
from obscli.pipelines.describe.signals import taken_as_exact
from obscli.pipelines.latex_names import latex_names
from obscli.pipelines.measures_result import MeasuresResult, Taken
from obscli.pipelines.stage_result import systems_of


#: Closed forms longer than this are left out, and directions are cut after so many states.
LONGEST: Final = 24
MOST_STATES: Final = 4

#: So many directions of a list are shown, the first and the last among them; all with details.
MOST_DIRECTIONS: Final = 6

FLAG: Final = "✗"
LEGEND: Final = f"{FLAG}: not observable by itself, whatever the number says."
SCALINGS: Final = {
    "none": "as the file gives them",
    "prior": "the prior's standard deviations",
    "scale": "the file's `scale`",
}


def measures_document(results: Iterable[MeasuresResult]) -> Document:
    """Return the measures of every stage."""
    results = tuple(results)
    stages = (block for result in results for block in _stage(result))
    return Document((*stages, *reading_blocks(results)))


def _stage(result: MeasuresResult) -> Iterator[Block]:
    yield Heading(1, (Text(f"{result.title}: measures of observability"),))
    match result.taken:
        case Undecided(reason=reason):
            yield VerdictLine("open", plain(f"undecided: {reason}"))
        case NotComputed(reason):
            yield VerdictLine("open", plain(f"not measured: {reason}"))
        case taken:
            yield _setting(result, taken)
            yield from taken_as_exact(systems_of(result.model, result.system))
            for one in taken:
                yield from _instant(result, one, several=len(taken) > 1)
            yield from limit_blocks(result)
            yield from note_blocks(result, taken)


def _setting(result: MeasuresResult, taken: Sequence[Taken]) -> Paragraph:
    horizon, subject = result.horizon, taken[-1].subject
    assert horizon is not None
    default = " (default)" if horizon.origin == "default" else ""
    at = ", ".join(number(one.subject.at) for one in taken)
    time = result.system.time
    words = (
        f"At {time} = {at}, from {time} = {number(horizon.start)}{default}. Rank {subject.rank} of "
        f"{subject.n} at the file's values. Units of the states: {SCALINGS[result.scaling]}."
    )
    return Paragraph(plain(words))


def _instant(result: MeasuresResult, taken: Taken, *, several: bool) -> Iterator[Block]:
    where = f" at {result.system.time} = {number(taken.subject.at)}" if several else ""
    across = [one for one in result.measures if _has_targets(taken, one)]
    states = [k for k, one in enumerate(taken.subject.targets) if one.kind != "combination"]
    others = [k for k, one in enumerate(taken.subject.targets) if one.kind == "combination"]
    if across:
        yield Heading(2, plain(f"States{where}"))
        yield _table(result, taken, across, states)
        if others:
            yield Heading(2, plain(f"Observable combinations{where}"))
            defined = [one for one in across if any(_value(taken, one, k) is not None for k in others)]
            yield _table(result, taken, defined, others)
    rows = tuple(_system_rows(result, taken))
    if rows:
        yield Heading(2, plain(f"The system as a whole{where}"))
        yield Table((Column("measure"), Column("value", breaks=True)), rows)
        yield from _directions(result, taken)


def _has_targets(taken: Taken, measure: Measure) -> bool:
    found = taken.found[measure.key]
    return isinstance(found, Found) and bool(found.targets)


def _value(taken: Taken, measure: Measure, k: int) -> float | None:
    found = taken.found[measure.key]
    assert isinstance(found, Found)
    return found.targets[k]


def _table(result: MeasuresResult, taken: Taken, across: Sequence[Measure], rows: Sequence[int]) -> Table:
    targets = taken.subject.targets
    columns = (Column("", breaks=True), *(Column(one.symbol, "right") for one in across))
    flagged = any(targets[k].observable is False for k in rows)
    return Table(
        columns,
        tuple((_name(result, targets[k]), *(_cell(result, taken, one, k) for one in across)) for k in rows),
        (Text(LEGEND, "faint"),) if flagged else (),
        folds=True,
    )


def _name(result: MeasuresResult, target: Target) -> Cell:
    if target.kind == "combination":
        return line(combination(target.coefficients, result.system))
    return line(Text(target.name, "name"))


def _cell(result: MeasuresResult, taken: Taken, measure: Measure, k: int) -> Cell:
    """Return a value with the flag of its target, and its closed form below it."""
    target, value = taken.subject.targets[k], _value(taken, measure, k)
    if value is None:
        return line(Text("–", "faint"))
    text = short(value, 4)
    found = taken.found[measure.key]
    assert isinstance(found, Found)
    form = _form(result, found, target.name)
    if target.observable is False:
        return line(Text(f"{text} "), Text(FLAG, "bad"))
    if target.observable is None:
        return line(Text(f"{text} ?", "open"))
    return (Text(text),), *form


def _form(result: MeasuresResult, found: Found, name: str) -> tuple[Inline, ...]:
    """Return the closed form of a value, where there is one to read."""
    form = found.forms.get(name)
    if form is None or not symbols(form):
        return ()
    text = to_text(form)
    return (
        ((Math(f"= {text}", f"= {to_latex(form, latex_names(result.system))}"),),)
        if len(text) <= LONGEST
        else ()
    )


def _system_rows(result: MeasuresResult, taken: Taken) -> Iterator[tuple[Cell, ...]]:
    for measure in result.measures:
        found = taken.found[measure.key]
        if not isinstance(found, Found):
            continue
        for key, value in found.system.items():
            if not isinstance(value, tuple):
                yield line(Text(key)), ((Text(short(value, 6)),), *_form(result, found, key))
            elif measure.key != "deterministic":
                yield line(Text(key)), line(Text(_sizes([one.value for one in value])))


def _sizes(values: Sequence[float]) -> str:
    """Return numbers in a row, repeated ones counted, the middle of many left out."""
    runs = [(short(value, 4), len(list(same))) for value, same in groupby(values)]
    texts = [f"{text} (×{count})" if count > 1 else text for text, count in runs]
    half = MOST_DIRECTIONS // 2
    return ", ".join(texts if len(texts) <= MOST_DIRECTIONS else (*texts[:half], "…", *texts[-half:]))


def _directions(result: MeasuresResult, taken: Taken) -> Iterator[Block]:
    """Yield the directions that belong to singular values, eigenvalues and modes."""
    blocks: list[Block] = []
    for measure in result.measures:
        found = taken.found[measure.key]
        if not isinstance(found, Found):
            continue
        for key, value in found.system.items():
            if isinstance(value, tuple):
                blocks += [Paragraph(plain(f"{key}:")), Listing(tuple(_direction(one) for one in value))]
    if blocks:
        yield Details(tuple(blocks))


def _direction(one: Direction) -> Inline:
    largest = sorted(one.components.items(), key=lambda pair: -abs(pair[1]))[:MOST_STATES]
    parts = ", ".join(f"{name}: {short(value, 3)}" for name, value in largest)
    more = ", …" if len(one.components) > len(largest) else ""
    mode = "" if one.eigenvalue is None else f" (eigenvalue {_complex(one.eigenvalue)})"
    return plain(f"{short(one.value, 4)}{mode}" + (f" along {parts}{more}" if parts else ""))


def _complex(value: complex) -> str:
    return (
        short(value.real, 4) if not value.imag else f"{short(value.real, 4)} ± {short(abs(value.imag), 4)}i"
    )
