"""How measures are read, what was asked of them and missed, and what a reader of their tables has to know."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from obscli.core.document import Block, Heading, Listing, Note, Paragraph, Text, VerdictLine, plain
from obscli.core.number import counted, short
from obscli.core.number import plain as number
from obscli.measures.measure import Found, Measure
from obscli.model.system import System
from obscli.numeric.finding import NotComputed
from obscli.pipelines.measures_result import Limit, MeasuresResult, Taken
from obscli.pipelines.stage_result import SEGMENTS


#: So many states of a ranking are named.
MOST_RANKED: Final = 6

UNITS: Final = {
    "none": "in the file's units",
    "prior": "in units of the prior",
    "scale": "in units of `scale`",
}
OVER: Final = "direction over the interval"

#: What stands in the readings for discrete-time systems: L_j = H F^j are the samples j steps later.
OF_STEPS: Final = {
    "outputs and derivatives": "outputs and later samples",
    "a derivative of an output": "a later sample of an output",
    "of an output or of a derivative": "of an output or of a later sample",
    OVER: "direction at the start of the interval",
}
BETTER: Final = {"larger": "larger is better", "smaller": "smaller is better"}


def reading_blocks(results: Sequence[MeasuresResult]) -> Iterator[Block]:
    """Say how each measure taken is read, once for all stages."""
    taken = [one.taken[-1] for one in results if isinstance(one.taken, tuple)]
    shown = [
        measure
        for measure in (results[0].measures if results else ())
        if any(isinstance(one.found[measure.key], Found) for one in taken)
    ]
    if not shown:
        return
    yield Heading(1, plain("How to read the measures"))
    options, words = taken[-1].subject.options, _words(taken[-1].subject.system)
    told = ((one, _replaced(_reading(one, options), words)) for one in shown)
    yield Listing(tuple((Text(one.symbol, "strong"), Text(text)) for one, text in told))
    scaled = ", ".join(one.symbol for one in shown if one.scaled)
    if scaled:
        yield Paragraph(plain(f"With the units of the states change: {scaled}."))


def _words(system: System) -> Mapping[str, str]:
    """Return what stands for words of readings in discrete time; of segments W is of the state at the end."""
    if not system.discrete:
        return {}
    return OF_STEPS | ({OVER: "direction at the end of the segments"} if system.stage == SEGMENTS else {})


def _replaced(text: str, words: Mapping[str, str]) -> str:
    for before, after in words.items():
        text = text.replace(before, after)
    return text


def _reading(measure: Measure, options: Mapping[str, Mapping[str, float | str]]) -> str:
    parts = [] if measure.better is None else [BETTER[measure.better]]
    parts.append(measure.reading)
    if measure.options:
        given = options[measure.key]
        parts.append(", ".join(f"{name} = {_option(value)}" for name, value in given.items()))
    return f" {measure.title}: {'; '.join(parts)}"


def _option(value: float | str) -> str:
    return value if isinstance(value, str) else short(value, 6)


def limit_blocks(result: MeasuresResult) -> Iterator[Block]:
    """Say which values asked for are missed, and how many are met."""
    for one in result.limits:
        if one.met is None:
            asked = f"asked for {short(one.limit, 4)}"
            yield VerdictLine("open", plain(f"{one.target}: {one.key} is not known, {asked}"))
        elif not one.met:
            yield VerdictLine("bad", plain(_missed(one, result)))
    met, count = sum(one.met is True for one in result.limits), len(result.limits)
    if met:
        yield VerdictLine("good", plain(f"{met} of {counted(count, 'value')} asked for met"))


def _missed(one: Limit, result: MeasuresResult) -> str:
    assert isinstance(result.taken, tuple)
    target = next(known for known in result.taken[-1].subject.targets if known.name == one.target)
    better = next(measure.better for measure in result.measures if measure.key == one.key)
    asked = "at most" if better == "smaller" else "at least"
    assert one.value is not None
    hidden = (
        ""
        if target.observable is not False or one.key == "standard-deviation"
        else ", and it is not observable"
    )
    return (
        f"{one.target}: {one.key} is {short(one.value, 4)}{hidden}, {asked} {short(one.limit, 4)} asked for"
    )


def note_blocks(result: MeasuresResult, taken: Sequence[Taken]) -> Iterator[Block]:
    """Yield warnings, what could not be measured and why, and what had to be assumed."""
    reasons: dict[str, list[str]] = {}
    warnings: dict[str, None] = {}
    for one in taken:
        where = f" at {number(one.subject.at)}" if len(taken) > 1 else ""
        for measure in result.measures:
            found = one.found[measure.key]
            if isinstance(found, NotComputed):
                reasons.setdefault(found.reason, []).append(f"{measure.key}{where}")
            else:
                warnings.update(dict.fromkeys(f"{measure.key}: {remark}" for remark in found.remarks))
    yield from (Note("warning", plain(words)) for words in warnings)
    for reason, keys in reasons.items():
        yield Note("note", plain(f"not measured: {', '.join(keys)}: {reason}"))
    if result.assumed_step is not None:
        words = "the file does not say how often there is a sample: one every"
        yield Note("note", plain(f"{words} {short(result.assumed_step, 4)} is taken (--step)"))
    if result.sampled:
        words = "left open in the file, taken along a sample motion"
        yield Note(
            "note", plain(f"{', '.join(result.sampled)}: {words}; the numbers are those of that motion")
        )
    yield from _reordered(result)


def _reordered(result: MeasuresResult) -> Iterator[Block]:
    """Warn where the ranking of the states is one of their units; measures that rank alike together."""
    symbols_of = {measure.key: measure.symbol for measure in result.measures}
    alike: dict[tuple[str, tuple[str, ...], tuple[str, ...]], list[str]] = {}
    for one in result.reordered:
        alike.setdefault((one.units, one.given, one.other), []).append(symbols_of[one.key])
    for (units, given, other), which in alike.items():
        words = (
            f"the ranking of the states by {', '.join(which)} depends on their units. Best first, "
            f"{UNITS[result.scaling]}: {_few(given)}; {UNITS[units]}: {_few(other)}"
        )
        yield Note("warning", plain(words))


def _few(names: tuple[str, ...]) -> str:
    return ", ".join(names if len(names) <= MOST_RANKED else (*names[:MOST_RANKED], "…"))
