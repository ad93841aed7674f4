"""What the record of the signals is, and how much of the rank is motion rather than noise."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

from obscli.core.document import Block, Cell, Column, Heading, Note, Table, Text, line, plain
from obscli.core.number import counted, short
from obscli.core.number import plain as number
from obscli.exact.finding import Analysis
from obscli.model.system import System
from obscli.numeric.finding import NumericFinding, SignalsFinding
from obscli.pipelines.describe.words import names
from obscli.pipelines.stage_result import StageResult


COLUMNS: Final = (Column(), Column(breaks=True))
EXACT: Final = (
    "signals taken as exact: noise in a log looks like motion, and may be all that makes a direction seem "
    "observable. Give its standard deviation, as in noise: {{signals: {{{name}: 0.05}}}}, to have it tested."
)


def signal_blocks(result: StageResult) -> Iterator[Block]:
    """Yield the files, the noise, and what of the rank stands clear of it."""
    found = result.numeric
    if not isinstance(found, NumericFinding) or found.signals is None:
        return
    signals = found.signals
    yield Heading(2, plain("Signals"))
    yield Table(COLUMNS, tuple(_facts(result, found, signals)))
    for text in signals.doubts:
        yield Note("warning", plain(text))
    if not signals.noise:
        yield Note("warning", plain(EXACT.format(name=signals.files[0].names[0])))
    if signals.reason:
        yield Note("warning", plain(f"the work of noise could not be told: {signals.reason}"))


def _facts(result: StageResult, found: NumericFinding, signals: SignalsFinding) -> Iterator[tuple[Cell, ...]]:
    for one in signals.files:
        span = f"{one.count} samples from {number(one.start)} to {number(one.stop)}, {one.interpolation}: "
        yield line(Text(one.file)), (((Text(span), *names(one.names)),))
    if signals.noise:
        given = ", ".join(f"{name}: {short(size)}" for name, size in signals.noise.items())
        yield line(Text("noise")), line(Text(given))
    yield line(Text("excited")), line(*_excited(found, signals))
    missing = not_excited(result)
    if missing:
        yield line(Text("not excited")), (names(missing),)


def _excited(found: NumericFinding, signals: SignalsFinding) -> Iterator[Text]:
    n = found.system.n
    if signals.excited is None or signals.t is None:
        rank = "?" if found.rank is None else str(found.rank)
        yield Text(rank, "strong")
        yield Text(f" of {counted(n, 'direction')}, with the signals as they are recorded")
        return
    yield Text(str(signals.excited), "strong")
    yield Text(f" of {counted(n, 'direction')} up to {number(signals.t)}")
    if signals.is_noise:
        yield Text(f"; the Gramian shows {signals.shown}", "open")
    if signals.clear is not None and signals.clear != signals.shown:
        noise = ", ".join(short(ratio) for ratio in signals.ratios[signals.clear :])
        yield Text(f", {signals.clear} of them better than white noise alone would (record over noise of the")
        yield Text(f" others: {noise})")
    elif signals.ratios:
        yield Text(f"; the weakest stands {short(signals.ratios[-1])} times above white noise")
    if signals.calm is not None and signals.is_noise:
        yield Text(f"; the calmest signals that the noise explains show {signals.calm}")


def taken_as_exact(systems: Sequence[System], *, asks: bool = True) -> Iterator[Block]:
    """Yield that what follows takes recorded signals of systems for what they say, where there are any.

    Parameters
    ----------
    asks : whether doubts about their units follow
    """
    recorded = tuple(dict.fromkeys(name for system in systems for name in system.sampled))
    if recorded:
        from obscli.numeric.signal_units import doubts  # noqa: PLC0415 - needs numpy, of recorded signals only

        text = (
            f"signals taken as exact: {', '.join(recorded)}; what noise in them alone would show is "
            "told by `obscli analyze` with their deviations under `noise`"
        )
        yield Note("note", plain(text))
        for doubt in dict.fromkeys(text for system in systems if asks for text in doubts(system)):
            yield Note("warning", plain(doubt))


def excited_rank(result: StageResult) -> int | None:
    """Return how many directions a record excites, None where there are no signals or nothing is clear."""
    found = result.numeric
    if not isinstance(found, NumericFinding) or found.signals is None:
        return None
    return found.rank if found.signals.excited is None else found.signals.excited


def not_excited(result: StageResult) -> tuple[str, ...]:
    """Return the states that motion would make observable, and this record does not."""
    found = result.numeric
    if not isinstance(found, NumericFinding) or found.signals is None:
        return ()
    seen = found.states
    hidden = {name for name, own in seen.items() if own != "observable"} | set(found.signals.not_excited)
    generic = result.finding.states if isinstance(result.finding, Analysis) else None
    return tuple(
        name
        for name in found.system.state_names
        if name in hidden and (generic is None or generic.get(name) == "observable")
    )
