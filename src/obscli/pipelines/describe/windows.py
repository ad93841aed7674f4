"""Local observability along an interval as tables: rank, states, where they gain, segments, motion."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Final

import numpy as np

from obscli.core.document import (
    Block,
    Cell,
    Column,
    Document,
    Heading,
    Listing,
    Note,
    Paragraph,
    Table,
    Text,
    VerdictLine,
    line,
    plain,
)
from obscli.core.number import counted, short
from obscli.core.number import plain as number
from obscli.exact.motion import MotionNeeds
from obscli.numeric.finding import NotComputed
from obscli.numeric.piecewise_constant import PiecewiseConstant
from obscli.numeric.program import Array
from obscli.pipelines.describe.measures import FLAG
from obscli.pipelines.describe.signals import taken_as_exact
from obscli.pipelines.windows_result import Gain, Windows, WindowsResult


#: Stretches of one rank, and ranges of time, that are listed.
MOST_STRETCHES: Final = 8
MOST_RANGES: Final = 4

STATES: Final = {
    "prior": "units of the prior's standard deviations",
    "scale": "units of the file's `scale`",
    "none": "the file's units",
}
LEGEND: Final = f"{FLAG}: not identifiable within a window by itself, whatever σ̃ says."
READINGS: Final = (
    ("σ̃", "equivalent singular value: average gain from the state at the start of a window to its samples"),
    ("‖Re‖", "column norm: how much the state alone would show, whatever hides it"),
    ("d", "residual index: what is left of that where all other states do their best to hide it; 0: hidden"),
    ("p", "posterior/prior: what one window leaves of the prior's deviation; smaller is better"),
)


def windows_document(results: Iterable[WindowsResult]) -> Document:
    """Return the windows of every stage."""
    results = tuple(results)
    stages = tuple(block for result in results for block in _stage(result))
    if not any(isinstance(one.found, Windows) for one in results):
        return Document(stages)
    readings = tuple((Text(symbol, "strong"), Text(f" {reading}")) for symbol, reading in READINGS)
    return Document((*stages, Heading(1, plain("How to read the values")), Listing(readings)))


def _stage(result: WindowsResult) -> Iterator[Block]:
    yield Heading(1, plain(f"{result.title}: observability in windows"))
    found = result.found
    if isinstance(found, NotComputed):
        yield VerdictLine("open", plain(f"not measured: {found.reason}"))
    else:
        yield Paragraph(plain(_setting(result, found)))
        for one in found.warnings:
            yield Note("warning", plain(one))
        yield from taken_as_exact([result.system], asks=False)
        yield from _rank(result, found)
        yield from _states(found)
        yield from _gains(result, found)
        yield from _segments(result, found)
    if result.needs is not None:
        names = (*result.system.state_names, *(one.name for one in result.system.quantities))
        shown = names if isinstance(found, NotComputed) else [names[k] for k in found.shown]
        yield from _needs(result.needs, names, shown)


def _setting(result: WindowsResult, found: Windows) -> str:
    request, sampling, scaling, time = result.request, found.sampling, found.scaling, result.system.time
    default = " (default)" if found.horizon.origin == "default" else ""
    start, stop = number(found.horizon.start), number(found.horizon.stop)
    held = "kept as at the start of each" if request.frozen else "varying along each"
    what = (
        f"{counted(sampling.samples, 'sample')} each, {number(sampling.h)} apart"
        if request.stack == "discrete"
        else f"outputs and derivatives up to order {min(sampling.samples, result.system.n) - 1}"
    )
    outputs = "unweighed" if scaling.weights is None else "in units of their noise"
    mu = "" if request.weights == "squared" else " σ̃ weighs by |v| (--mu abs), not by v²."
    thinned = f" Every {found.every}-th is reported." if found.every > 1 else ""
    return (
        f"{counted(sampling.windows, 'window')} of {number(request.length)}, {number(sampling.step)} apart, "
        f"from {time} = {start} to {stop}{default}; {what}; A and H {held}. "
        f"States in {STATES[scaling.origin]}, outputs {outputs}.{mu}{thinned}"
    )


def _rank(result: WindowsResult, found: Windows) -> Iterator[Block]:
    values, n = found.values, result.system.n
    change = np.flatnonzero(np.diff(values.rank)) + 1
    parts = np.split(np.arange(len(values.t)), change)
    yield Heading(2, plain("Rank"))
    if len(parts) == 1:
        yield Paragraph(plain(f"{int(values.rank[0])} of {n} in every window."))
        return
    rows = tuple(
        (
            line(Text(_range(values.t[part[0]], values.t[part[-1]]))),
            line(Text(str(int(values.rank[part[0]])))),
        )
        for part in parts[:MOST_STRETCHES]
    )
    more = len(parts) - len(rows)
    caption = (Text(f"The rank changes {counted(more, 'further time')}.", "faint"),)
    yield Table((Column("windows from"), Column(f"rank of {n}", "right")), rows, caption if more else ())


def _states(found: Windows) -> Iterator[Block]:
    values = found.values
    informed = bool(np.isfinite(values.posterior).all())
    titles = ["σ̃ least", "σ̃ median", "σ̃ largest", "‖Re‖ median", "d median"]
    titles += ["p median", "p best", "at"] if informed else []
    yield Heading(2, plain("States and quantities"))
    rows = tuple(_row(found, k, informed=informed) for k in found.shown)
    hidden = bool((values.residual[:, list(found.shown)] == 0).all(axis=0).any())
    columns = (Column(""), *(Column(title, "right") for title in titles))
    yield Table(columns, rows, (Text(LEGEND, "faint"),) if hidden else (), folds=True)


def _row(found: Windows, k: int, *, informed: bool) -> tuple[Cell, ...]:
    values = found.values
    index, residual = values.equivalent[:, k], values.residual[:, k]
    cells = [_number(index.min()), _number(np.median(index)), _number(index.max())]
    cells.append(_number(np.median(values.column_norm[:, k])))
    cells.append(
        line(Text("0 "), Text(FLAG, "bad")) if (residual == 0).all() else _number(np.median(residual))
    )
    if informed:
        p = values.posterior[:, k]
        best = int(p.argmin())
        cells += [_number(np.median(p)), _number(p[best]), _number(values.t[best])]
    return (line(Text(found.names[k], "name")), *cells)


def _number(value: Array | float) -> Cell:
    return line(Text(short(float(value), 4)))


def _gains(result: WindowsResult, found: Windows) -> Iterator[Block]:
    yield Heading(2, plain("Which part of the interval states gain from"))
    judged = "1 − p" if found.gains[0].key == "posterior-ratio" else "σ̃"
    shown = [found.gains[k] for k in found.shown]
    rows = tuple((line(Text(one.target, "name")), line(Text(_gain(one)))) for one in shown)
    caption = f"Windows that start there do at least half as well as the best, by {judged}."
    yield Table((Column(""), Column(f"{result.system.time} from … to", breaks=True)), rows, plain(caption))


def _gain(one: Gain) -> str:
    if not one.ranges:
        return "no window tells more than a hundredth"
    shown = ", ".join(_range(*pair) for pair in one.ranges[:MOST_RANGES])
    more = len(one.ranges) - MOST_RANGES
    rest = f", and {more} more" if more > 0 else ""
    return f"{shown}{rest}; best at {number(one.at)} ({short(one.best, 3)})"


def _range(first: Array | float, last: Array | float) -> str:
    one, other = number(float(first)), number(float(last))
    return one if one == other else f"{one} … {other}"


def _segments(result: WindowsResult, found: Windows) -> Iterator[Block]:
    segments, n = found.segments, result.system.n
    yield Heading(2, plain("Piecewise constant: segments one after the other"))
    if isinstance(segments, NotComputed):
        yield VerdictLine("open", plain(f"not analysed: {segments.reason}"))
        return
    if segments.holds:
        words = "null(Q_j) ⊂ null(A_j) in every segment: the stripped matrix has the rank of the total one"
        yield VerdictLine("good", plain(words))
    else:
        count = int(segments.violated.sum())
        words = f"null(Q_j) ⊂ null(A_j) is violated in {count} of {counted(len(segments.starts), 'segment')}"
        yield VerdictLine("bad", plain(words))
    local = sorted(set(segments.local_rank.tolist()))
    ranks = str(local[0]) if len(local) == 1 else f"{local[0]} to {local[-1]}"
    total, stripped = int(segments.total_rank[-1]), int(segments.stripped_rank[-1])
    smallest = [short(float(one[-1])) for one in (segments.total_values, segments.stripped_values)]
    yield Paragraph(
        plain(
            f"{counted(len(segments.starts), 'segment')}: local rank {ranks}; together, the state carried "
            f"through, {total} of {n} (TOM), stripped {stripped} (SOM); smallest singular values "
            f"{' and '.join(smallest)}: the SOM stands in for a rank, never for a degree."
        )
    )
    yield Table((Column("observable from"), Column("", breaks=True)), tuple(_since(found, segments)))


def _since(found: Windows, segments: PiecewiseConstant) -> Iterator[tuple[Cell, Cell]]:
    """Yield the linear forms of the start by the end of the segment that makes them observable."""
    by_time: dict[float, list[str]] = {}
    since = [(found.names[k], float(segments.since[k])) for k in found.shown]
    never = [name for name, t in since if np.isnan(t)]
    for name, t in since:
        if name not in never:
            by_time.setdefault(t, []).append(name)
    for t, names in sorted(by_time.items()):
        yield line(Text(number(t))), line(Text(", ".join(names), "name"))
    if never:
        yield line(Text("never")), line(Text(", ".join(never), "name"))


def _needs(needs: MotionNeeds, names: Sequence[str], shown: Sequence[str]) -> Iterator[Block]:
    yield Heading(2, plain("Motion that the states need"))
    if needs.reason:
        yield Paragraph(plain(f"Not found: {needs.reason}."))
        return
    by_target: dict[str, list[str]] = {}
    for one in sorted(needs.needs, key=lambda one: names.index(one.target)):
        how = "different from zero" if one.kind == "zero" else "varying"
        if one.target in shown:
            by_target.setdefault(one.target, []).append(f"{_either(one.functions)} {how}")
    if not by_target:
        which = "No set that was tried" if needs.cut else "No set of up to three functions"
        yield Paragraph(plain(f"{which} is needed by any of them: where it is zero or constant others do."))
    for target, texts in by_target.items():
        yield Paragraph((Text(target, "name"), Text(f" needs {'; '.join(texts)}")))
    cut = "; larger or other ones were not tried" if needs.cut else ""
    yield Paragraph(plain(f"Proved; {counted(needs.tried, 'set')} of functions tried{cut}."))


def _either(functions: Sequence[str]) -> str:
    return functions[0] if len(functions) == 1 else f"{', '.join(functions[:-1])} or {functions[-1]}"
