"""Random runs and a mismatched filter in the report: tables, and one sentence what they say of the filter.

NEES and NIS divided by their degrees of freedom are 1 on average where the filter is consistent. Their
averages over the instants are judged as χ²: of NIS, whose innovations are independent where the filter is
right, with the degrees of freedom of all instants; of NEES, whose values hang together in time, with those of
one instant, which is the most that such an average can spread. What is outside a narrow band is told, but a
filter is called wrong only outside a wide one: with two measures, a right one is in 2 (1 − 0.999) of all
series of runs at the most.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from obscli.core.document import (
    Block,
    Cell,
    Column,
    Heading,
    Kind,
    Paragraph,
    Table,
    Text,
    VerdictLine,
    line,
    plain,
)
from obscli.core.number import counted, short
from obscli.core.number import plain as number
from obscli.numeric.chi_squared import chi_squared_band
from obscli.pipelines.describe.words import names as listed
from obscli.pipelines.describe.words import ratio
from obscli.pipelines.simulate_result import Demand, Mismatch


if TYPE_CHECKING:
    from obscli.numeric.simulation_finding import Consistency, MonteCarlo

MISMATCH_COLUMNS: Final = (
    Column("", breaks=True),
    Column("unit"),
    Column("claimed", "right"),
    Column("true", "right"),
    Column("true/claimed", "right"),
    Column("at worst", "right"),
    Column("when", "right"),
)
MISMATCH_LEGEND: Final = (
    "one standard deviation at the end, in the units of the file: as the filter has it, and as it is; above "
    "1 the filter is optimistic, below 1 it could claim less."
)
DEMANDED: Final = (Column("required", "right"), Column())
RUNS_COLUMNS: Final = (
    Column("", breaks=True),
    Column("claimed", "right"),
    Column("rms", "right"),
    Column("rms/claimed", "right"),
    Column("mean", "right"),
)
CONSISTENCY_COLUMNS: Final = (
    Column(),
    Column("average", "right"),
    Column("band", "right"),
    Column("inside", "right"),
)

#: A filter is called wrong outside the band of this probability. With two measures a right one is there at
#: most so often, and outside a band of 95 % so often.
REFUTED: Final = 0.999
FALSE_ALARMS: Final = "1 of 500"
CHANCE: Final = "1 in 10"

#: Ratios this close to 1 are printed as 1.00.
SAME: Final = 0.005


@dataclass(frozen=True, slots=True)
class Judgement:
    """The average over all instants of a χ² measure, and the band that it is to be in.

    ``refuted``: it is outside a band that a right filter leaves in one of a thousand series of runs.
    """

    name: str
    average: float
    lower: float
    upper: float
    inside: float
    refuted: bool

    @property
    def side(self) -> str:
        """Where the average is: above or below the band, or in it (empty)."""
        return "above" if self.average > self.upper else "below" if self.average < self.lower else ""


def judged(name: str, found: Consistency, confidence: float, *, independent: bool) -> Judgement:
    """Return the average over the instants, weighted by degrees of freedom, with the bands of its own."""
    average = float(found.average @ found.degrees / found.degrees.sum())
    degrees = np.array([found.degrees.sum() if independent else found.degrees.min()])
    (lower,), (upper,) = chi_squared_band(degrees, confidence)
    (least,), (most,) = chi_squared_band(degrees, REFUTED)
    return Judgement(name, average, float(lower), float(upper), found.inside, not least <= average <= most)


def judgements(found: MonteCarlo) -> tuple[Judgement, ...]:
    """Return NEES where something is uncertain, and NIS where something is sampled."""
    parts = (("NEES", found.nees, False), ("NIS", found.nis, True))
    return tuple(
        judged(name, one, found.confidence, independent=independent)
        for name, one, independent in parts
        if one is not None
    )


def demanded(demands: Iterable[Demand], name: str) -> tuple[Cell, Cell]:
    """Return what is required of a form, and whether that is met."""
    own = next((one for one in demands if one.name == name), None)
    if own is None:
        return line(Text("–")), line(Text(""))
    met = Text("✓", "good") if own.is_met else Text("✗", "bad")
    return line(Text(short(own.limit, 3))), line(met)


def runs_blocks(found: MonteCarlo, names: Mapping[str, Cell], *, mismatched: bool) -> Iterator[Block]:
    """Yield how the errors of the random runs spread against what the filter claims; ``names``: as set."""
    whose = " of the filter on the truth" if mismatched else ""
    yield Heading(2, plain(f"{counted(found.runs, 'random run')}{whose} (seed {found.seed})"))
    rows = tuple(
        (
            names.get(name) or line(Text(name, "name")),
            line(Text(short(float(claimed), 3))),
            line(Text(short(float(rms), 3))),
            line(Text(ratio(float(rms / claimed)) if claimed > 0 else "–")),
            line(Text(short(float(mean), 3))),
        )
        for name, claimed, rms, mean in zip(
            found.names, found.claimed[-1], found.rms[-1], found.mean[-1], strict=True
        )
    )
    legend = (
        "at the end: the deviation claimed, root mean square and mean of the errors; of so many runs an rms "
        f"is good to {short(100 / math.sqrt(2 * found.runs))} %."
    )
    yield Table(RUNS_COLUMNS, rows, (Text(legend, "faint"),))
    told = judgements(found)
    yield Heading(2, plain("Consistency of the runs"))
    yield Table(
        CONSISTENCY_COLUMNS, tuple(_judgement_row(one) for one in told), (Text(_band(found), "faint"),)
    )
    yield _given_verdict() if found.inserted else _runs_verdict(told)


def _band(found: MonteCarlo) -> str:
    return (
        "NEES: eᵀP⁻¹e of the errors, NIS: νᵀS⁻¹ν of the innovations, over their degrees of freedom and "
        f"averaged over runs and instants: 1 is expected, in the band with {short(100 * found.confidence)} "
        "%; inside: instants at which the average over the runs is in its own band. A filter is called wrong "
        f"outside the band of {short(100 * REFUTED, 4)} %, where a right one is in at most {FALSE_ALARMS} "
        "series of runs."
    )


def _judgement_row(one: Judgement) -> tuple[Cell, ...]:
    return (
        line(Text(one.name)),
        line(Text(f"{one.average:.3f}" if one.average < 100 else short(one.average, 3))),
        line(Text(f"{one.lower:.3f} … {one.upper:.3f}")),
        line(Text(f"{100 * one.inside:.0f} %")),
    )


def _given_verdict() -> VerdictLine:
    words = (
        "not judged: errors at the start are given (--initial) and the same in all runs, where the filter "
        "expects them drawn from P0"
    )
    return VerdictLine("open", plain(words))


def _runs_verdict(told: tuple[Judgement, ...]) -> VerdictLine:
    outside = [f"{one.name} {one.side}" for one in told if one.side]
    above = [one.name for one in told if one.refuted and one.side == "above"]
    below = [one.name for one in told if one.refuted and one.side == "below"]
    kind: Kind = "bad" if above else "open" if outside else "good"
    if not told:
        kind = "open"
        words = "not decided: the filter claims to know everything, and no output is sampled"
    elif above and below:
        words = f"inconsistent: {' and '.join(above)} above the band, {' and '.join(below)} below"
    elif above:
        words = f"optimistic: errors are larger than the filter claims ({' and '.join(above)} above the band)"
    elif below:
        words = (
            f"pessimistic: errors are smaller than the filter claims ({' and '.join(below)} below the band)"
        )
    elif outside:
        words = (
            f"not decided: {', '.join(outside)} the band, as up to {CHANCE} right filters is; more runs tell "
            "(--runs)"
        )
    else:
        words = "consistent: errors are as large as the filter claims"
    return VerdictLine(kind, plain(words))


def mismatch_blocks(one: Mismatch) -> Iterator[Block]:
    """Yield what the filter designed on another model claims, and what its errors are."""
    whose = one.model.name if one.system.stage is None else f"{one.model.name} · {one.system.stage}"
    yield Heading(2, plain(f"The filter designed on {whose}"))
    units = {state.name: state.unit for state in one.system.states}
    columns = (*MISMATCH_COLUMNS, *DEMANDED) if one.demands else MISMATCH_COLUMNS
    rows = tuple(
        (
            line(Text(name, "name")),
            line(Text(units.get(name, ""), "faint")),
            line(Text(short(float(claimed), 3))),
            line(Text(short(float(true), 3))),
            line(Text(ratio(own.end))),
            line(Text(ratio(own.worst))),
            line(Text(number(own.when))),
            *(demanded(one.demands, name) if one.demands else ()),
        )
        for name, claimed, true, own in zip(
            one.history.names, one.history.claimed[-1], one.history.true[-1], one.ratios, strict=True
        )
    )
    yield Table(columns, rows, (Text(MISMATCH_LEGEND, "faint"),), folds=True)
    if one.history.ignored:
        yield Paragraph((Text("The filter leaves out "), *listed(one.history.ignored), Text(".")))
    yield _mismatch_verdict(one)


def _mismatch_verdict(one: Mismatch) -> VerdictLine:
    worst = max(one.ratios, key=lambda own: own.end)
    if worst.end > 1 + SAME:
        others = sum(own.end > 1 + SAME for own in one.ratios) - 1
        more = f", and about {counted(others, 'other')} by less" if others else ""
        words = f"the filter is optimistic about {worst.name} by {ratio(worst.end)} at the end{more}"
        return VerdictLine("bad", plain(words))
    before = max(one.ratios, key=lambda own: own.worst)
    if before.worst > 1 + SAME:
        words = (
            f"at the end the filter claims no more than it reaches; it was optimistic about {before.name} by "
            f"{ratio(before.worst)} at {number(before.when)}"
        )
        return VerdictLine("open", plain(words))
    least = min(one.ratios, key=lambda own: own.end)
    if least.end < 1 - SAME:
        factor = ratio(1 / least.end) if least.end else "inf"
        words = f"pessimistic: errors are smaller than the filter claims, of {least.name} by {factor}"
        return VerdictLine("good", plain(words))
    return VerdictLine("good", plain("the filter claims what it reaches"))
