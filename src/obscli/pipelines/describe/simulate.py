"""The report on a simulation of the Kalman filter: what was sampled, how well each form is known."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from obscli.core.document import (
    Block,
    Cell,
    Column,
    Details,
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
from obscli.numeric.finding import NotComputed
from obscli.pipelines.describe.formulas import combination
from obscli.pipelines.describe.signals import taken_as_exact
from obscli.pipelines.describe.simulate_mean import feedback_note, mean_blocks
from obscli.pipelines.describe.simulate_runs import DEMANDED, demanded, mismatch_blocks, runs_blocks
from obscli.pipelines.describe.words import names, sign
from obscli.pipelines.simulate_result import FollowedForm, Sampling, SimulateResult, Simulation
from obscli.pipelines.stage_result import systems_of


if TYPE_CHECKING:
    from obscli.model.system import System
    from obscli.numeric.simulation_finding import Followed

FACT_COLUMNS: Final = (Column(), Column(breaks=True))
HEADINGS: Final[dict[Followed, str]] = {
    "state": "States",
    "quantity": "Quantities",
    "combination": "Observable combinations",
}
UNIT: Final = 2

#: So many outages of an output are listed, and at so many instants details show deviations.
MOST: Final = 4
_ALIKE: Final = 1e-6
SHOWN: Final = 6


def simulate_document(results: Iterable[SimulateResult]) -> Document:
    """Return the report on the stages of one model; tables are explained once."""
    blocks: list[Block] = []
    explained = False
    lacks: dict[str, str] = {}
    for result in results:
        if isinstance(result.found, NotComputed):
            before = lacks.setdefault(result.found.reason, result.title)
            if before != result.title:
                result = replace(result, found=NotComputed(f"the same is missing as in {before}"))  # noqa: PLW2901
        blocks += _blocks(result, explains=not explained, first=not blocks)
        explained |= not isinstance(result.found, NotComputed)
    return Document(tuple(blocks))


def _blocks(result: SimulateResult, *, explains: bool, first: bool) -> Iterator[Block]:
    yield Heading(1, (Text(result.title),))
    if first and result.model.title:
        yield Paragraph((Text(result.model.title, "strong"),))
    found = result.found
    if isinstance(found, NotComputed):
        yield Note("warning", plain(f"not simulated: {found.reason}"))
        return
    if result.interrupted:
        yield Note("warning", plain(_interrupted(found)))
    yield from _sampling_blocks(found, result.system)
    yield from taken_as_exact(systems_of(result.model, result.system))
    yield from _tables(result, found, explains=explains)
    yield Details(tuple(_course_blocks(result, found)))
    formulas = {form.name: _name(form, result) for form in found.forms}
    if found.feedback is not None:
        yield feedback_note(found.feedback, mismatched=found.mismatch is not None)
    if found.mismatch is not None:
        yield from mismatch_blocks(found.mismatch)
    if found.initial is not None:
        filtered = result.system if found.mismatch is None else found.mismatch.system
        yield from mean_blocks(found.initial, formulas, {one.name: one.unit for one in filtered.states})
    if found.monte_carlo is not None:
        yield from runs_blocks(found.monte_carlo, formulas, mismatched=found.mismatch is not None)
    yield from _verdict_blocks(found)


def _interrupted(found: Simulation) -> str:
    reached = float(found.history.t[-1])
    if not found.history.complete:
        return f"interrupted at t = {number(reached)} of {number(found.stop)}: all below holds until then"
    return "interrupted after the covariance was done: what comes after it is not complete"


def _sampling_blocks(found: Simulation, system: System) -> Iterator[Block]:
    """Yield the interval, what was sampled when, and what of that is not the file's."""
    rows = [(line(Text("interval")), line(Text(f"{number(found.start)} … {number(found.stop)}")))]
    rows.append((line(Text("samples")), line(Text(str(found.history.samples)))))
    alike: dict[str, list[str]] = {}
    for one in found.sampling:
        alike.setdefault(_rate(one), []).append(one.output)
    rows += [((names(tuple(outputs)),), line(Text(rate))) for rate, outputs in alike.items()]
    yield Table(FACT_COLUMNS, tuple(rows))
    if found.default:
        if system.discrete:
            taken = f"{number(found.stop - found.start)} steps are"
        else:
            taken = (
                "all that the files of signals cover is" if found.recorded else "20 over the fastest rate is"
            )
        yield Note("note", plain(f"the file gives no `interval`: {taken} taken"))
    if found.assumed_step is not None:
        step = number(found.assumed_step)
        text = f"R is a density and nothing says how often there is a sample: every {step} is taken (--step)"
        yield Note("note", plain(text))
    if found.sampled:
        functions = ", ".join(found.sampled)
        yield Note("note", plain(f"{functions}: functions left open, for which a sample motion is taken"))
    if found.unsaid:
        yield Note("warning", plain(f"what is observable is undecided: {found.unsaid}"))


def _rate(one: Sampling) -> str:
    if not one.samples:
        return "never sampled"
    every = "once" if one.every is None else f"every {number(one.every)}"
    if one.longest is not None and one.every is not None and one.longest > one.every * (1 + _ALIKE):
        every += f" to {number(one.longest)}"
    if not one.outages or one.every is None:
        return every
    gaps = [f"{number(start)} … {number(stop)}" for start, stop in one.outages]
    more = f" and {len(gaps) - MOST} more" if len(gaps) > MOST else ""
    return f"{every}; none in {', '.join(gaps[:MOST])}{more}"


def _tables(result: SimulateResult, found: Simulation, *, explains: bool) -> Iterator[Block]:
    """Yield the deviations: states, quantities, combinations, a table each."""
    for kind, heading in HEADINGS.items():
        indices = [k for k, form in enumerate(found.forms) if form.kind == kind]
        if not indices:
            continue
        yield Heading(2, plain(heading))
        rows = tuple(_row(result, found, k) for k in indices)
        caption = (Text(_legend(found), "faint"),) if explains and kind == "state" else ()
        yield _without_empty(Table(_columns(found, kind), rows, caption, folds=True))


def _without_empty(table: Table) -> Table:
    """Return the table without a column of units where there are none."""
    if any(row[UNIT] != line(Text("", "faint")) for row in table.rows):
        return table
    rows = tuple((*row[:UNIT], *row[UNIT + 1 :]) for row in table.rows)
    return replace(table, columns=(*table.columns[:UNIT], *table.columns[UNIT + 1 :]), rows=rows)


def _columns(found: Simulation, kind: Followed) -> tuple[Column, ...]:
    return (
        Column(kind, breaks=True),
        Column(),
        Column("unit"),
        Column("prior", "right"),
        Column("end", "right"),
        Column("of prior", "right"),
        Column("open loop", "right"),
        Column("known from", "right"),
        *(DEMANDED if found.demands else ()),
    )


def _legend(found: Simulation) -> str:
    limit = f"{short(found.fraction)} of the prior"
    if found.demands:
        limit = f"what is required, else below {limit}"
    words = (
        "one standard deviation, in the units of the file, before the first sample and at the end; open "
        f"loop: at the end, had nothing been measured; known from: when it falls below {limit} for good; not "
        "yet: not within the interval."
    )
    hidden = (
        " ● observable, ◐ only together with others, · not at all: what is not observable falls only as far "
        "as the prior ties it to what is."
    )
    return words + ("" if found.unsaid else hidden)


def _row(result: SimulateResult, found: Simulation, k: int) -> tuple[Cell, ...]:
    form, history, time = found.forms[k], found.history, found.times[k]
    prior, end = float(history.prior[k]), float(history.deviations[-1, k])
    reached = "not yet" if time.reached is None else number(time.reached)
    cells = (
        _name(form, result),
        line(Text("") if form.verdict is None else sign(form.verdict)),
        line(Text(form.unit, "faint")),
        line(Text(short(prior, 3))),
        line(Text(short(end, 3))),
        line(Text(short(end / prior, 2) if prior > 0 else "–")),
        line(Text(short(float(history.open_loop[-1, k]), 3))),
        line(Text(reached, "open" if time.reached is None else "plain")),
    )
    return (*cells, *demanded(found.demands, form.name)) if found.demands else cells


def _name(form: FollowedForm, result: SimulateResult) -> Cell:
    if form.kind == "combination":
        return line(combination(form.coefficients, result.system))
    return line(Text(form.name, "name"))


def _course_blocks(result: SimulateResult, found: Simulation) -> Iterator[Block]:
    """Yield the deviations of all forms at some instants."""
    t = found.history.t
    chosen = sorted({round(k * (len(t) - 1) / (SHOWN - 1)) for k in range(SHOWN)})
    columns = (Column("σ at", breaks=True), *(Column(number(float(t[k])), "right") for k in chosen))
    rows = tuple(
        (
            _name(form, result),
            *(line(Text(short(float(found.history.deviations[k, j]), 3))) for k in chosen),
        )
        for j, form in enumerate(found.forms)
    )
    yield Heading(2, plain("Deviations in time"))
    yield Table(columns, rows, folds=True)


def _verdict_blocks(found: Simulation) -> Iterator[Block]:
    yield Heading(2, plain("Verdict"))
    yield from _demand_lines(found)
    states = [
        (form, time) for form, time in zip(found.forms, found.times, strict=True) if form.kind == "state"
    ]
    late = tuple(form.name for form, time in states if time.reached is None)
    until = number(float(found.history.t[-1]))
    known = f"{len(states) - len(late)} of {counted(len(states), 'state')} known by {until}"
    limit = f"{'what is required, else ' if found.demands else ''}{short(found.fraction)} of the prior"
    yield VerdictLine("info", plain(f"{known} (within {limit})"))
    if late:
        yield Listing(((Text("not known by then: "), *names(late)),))


def _demand_lines(found: Simulation) -> Iterator[Block]:
    """Yield whether requirements are met, by the filter of the model itself and by that of another."""
    judged = [("", found.demands)]
    if found.mismatch is not None:
        judged.append((f"the filter designed on {found.mismatch.model.name}: ", found.mismatch.demands))
    for whose, demands in judged:
        failed = [one for one in demands if not one.is_met]
        if failed:
            listed = ", ".join(f"{one.name} ({short(one.after, 3)})" for one in failed[: 2 * MOST])
            more = f" and {len(failed) - 2 * MOST} more" if len(failed) > 2 * MOST else ""
            words = f"{whose}not as well known at the end as required: {listed}{more}"
            yield VerdictLine("bad", plain(words))
        elif demands:
            yield VerdictLine("good", plain(f"{whose}everything is as well known at the end as required"))
