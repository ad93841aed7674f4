"""The report on a plan: what to do, minute by minute, what it reaches, and what nothing on offer can."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import comb
from typing import Final

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
from obscli.core.verification import Verification
from obscli.exact.finding import Analysis
from obscli.experiment.planning import RankedSet
from obscli.pipelines.describe.accuracy import required_blocks
from obscli.pipelines.describe.formulas import combinations, direction
from obscli.pipelines.describe.words import names
from obscli.pipelines.plan_result import PlanResult


SHOWN: Final = 10
CANDIDATE_COLUMNS: Final = (
    Column("#", "right"),
    Column("candidate", breaks=True),
    Column("lasts", "right"),
    Column("determines", "right"),
)
SET_COLUMNS: Final = (
    Column("candidates", breaks=True),
    Column("takes", "right"),
    Column("worst margin", "right"),
    Column("shortened to", "right"),
)
STEP_COLUMNS: Final = (
    Column("#", "right"),
    Column("run", breaks=True),
    Column("lasts", "right"),
    Column("from, min", "right"),
    Column("to, min", "right"),
)
FACT_COLUMNS: Final = (Column(), Column(breaks=True))
SET_LEGEND: Final = (
    "takes: all runs at full length, with setting up; worst margin: the smallest of what is required over "
    "what is reached; shortened to: no run longer than the requirements need."
)


def plan_document(results: Iterable[PlanResult]) -> Document:
    """Return the report on plans."""
    return Document(tuple(block for result in results for block in _blocks(result)))


def _blocks(result: PlanResult) -> Iterator[Block]:
    yield Heading(1, (Text(result.title),))
    if result.model.title:
        yield Paragraph((Text(result.model.title, "strong"),))
    yield from _shared_blocks(result)
    yield from _chosen_blocks(result)
    if result.accuracy is not None:
        yield from required_blocks(result.accuracy)
    elif result.model.require:
        yield Note("warning", plain(f"whether the requirements are met is open: {result.plan.no_accuracy}"))
    yield from _missing_blocks(result)
    yield from _candidate_blocks(result)
    yield from _set_blocks(result)
    yield from _verdict_blocks(result)


def _shared_blocks(result: PlanResult) -> Iterator[Block]:
    plan = result.plan
    rows = [(line(Text(f"shared ({len(plan.shared)})", "strong")), (names(plan.shared) or plain("none"),))]
    if plan.fresh:
        rows.append((line(Text(f"fresh ({len(plan.fresh)})")), (names(plan.fresh),)))
    yield Table(FACT_COLUMNS, tuple(rows))
    if result.is_default:
        yield Note("note", plain("the file has no `experiment`: every stage counts as a run"))
    for one in plan.own:
        yield Note("note", plain(f"{one.name} stands for {one.of} = {one.value} in {', '.join(one.runs)}"))
    if plan.left_out:
        yield Note("note", plain(f"forbidden: {', '.join(plan.left_out)}"))


def _chosen_blocks(result: PlanResult) -> Iterator[Block]:
    """Yield the plan itself: runs one after the other, in minutes."""
    plan = result.plan
    chosen = plan.chosen
    yield Heading(2, plain("Plan"))
    if chosen is None:
        yield Paragraph(plain("No candidate determines anything."))
        return
    at, rows = 0.0, []
    lengths = [plan.durations[k] for k in chosen.runs]
    if chosen.shortest is not None:
        lengths = list(chosen.shortest.durations)
    for k, (run, lasts) in enumerate(zip(chosen.runs, lengths, strict=True), start=1):
        at += plan.setup_time
        rows.append(
            (
                line(Text(str(k), "faint")),
                line(Text(plan.runs[run].name, "name")),
                line(Text(number(lasts))),
                line(Text(_minutes(at))),
                line(Text(_minutes(at + lasts))),
            )
        )
        at += lasts
    total = f"{counted(len(chosen.runs), 'run')}, {_minutes(at)} min in all"
    setup = f", {number(plan.setup_time)} before each run to set it up" if plan.setup_time else ""
    caption = f"{total}{setup}; minutes if the unit of time is the second."
    yield Table(STEP_COLUMNS, tuple(rows), (Text(caption, "faint"),))
    yield from _how_chosen(result, chosen)


def _how_chosen(result: PlanResult, chosen: RankedSet) -> Iterator[Block]:
    plan = result.plan
    lines = []
    if plan.extended is not None:
        lines.append(
            f"the smallest sets ({counted(plan.found.size, 'run')}) do not meet what is required; runs were "
            "added, each the one that gains most for its time, and those no longer needed left out"
        )
    if chosen.shortest is not None:
        steps = ", ".join(dict.fromkeys(number(step) for step in chosen.shortest.steps))
        lines.append(
            f"each run is as short as the requirements allow, in steps of {steps}: none can end a step "
            f"earlier while the others stay; at full length it would take {_minutes(chosen.duration)} min"
        )
    elif chosen.margin is not None and not chosen.is_met:
        lines.append("what is required is not met, however many of these runs are made")
    if lines:
        yield Listing(tuple(plain(one) for one in lines))


def _missing_blocks(result: PlanResult) -> Iterator[Block]:
    """Yield what no candidate can determine, and which kind of run would."""
    plan = result.plan
    finding = plan.stack.finding
    assert isinstance(finding, Analysis)
    n = len(plan.shared)
    if not finding.unobservable:
        return
    count = counted(len(finding.unobservable), "direction")
    yield Heading(2, plain(f"What no candidate can determine ({count} of {n})"))
    rows = tuple(
        (line(Text(str(k), "faint")), line(direction(one, finding.system)))
        for k, one in enumerate(finding.unobservable, 1)
    )
    caption = "Change the shared states together in these proportions: no candidate shows it."
    yield Table((Column(align="right"), Column(breaks=True)), rows, (Text(caption, "faint"),))
    yield from _suggestion_blocks(result)


def _suggestion_blocks(result: PlanResult) -> Iterator[Block]:
    plan, n = result.plan, len(result.plan.shared)
    if plan.suggestions:
        yield Paragraph(plain("Which kind of run would, all candidates done again with it:"))
        rows = tuple(
            (line(Text(one.words)), line(Text(f"{one.rank} of {n}"))) for one in plan.suggestions[:SHOWN]
        )
        yield Table((Column(breaks=True), Column("then", "right")), rows)
    elif plan.tried:
        yield Paragraph(
            plain(f"None of the {len(plan.tried)} kinds of runs tried would: turned bodies, signs, values.")
        )
    tried = Listing(tuple(plain(one) for one in plan.tried))
    yield Details((Paragraph(plain("Tried:")), tried))


def _set_blocks(result: PlanResult) -> Iterator[Block]:
    """Yield the smallest sets, ranked."""
    plan, found = result.plan, result.plan.found
    if not found.sets:
        return
    yield Heading(2, plain(f"Smallest sets ({counted(found.size, 'run')})"))
    yield Paragraph(plain(_search(result)))
    shown = plan.ranked[:SHOWN]
    yield Table(SET_COLUMNS, tuple(_set_row(one) for one in shown), (Text(SET_LEGEND, "faint"),))
    if len(plan.ranked) > len(shown):
        rest = Table(SET_COLUMNS, tuple(_set_row(one) for one in plan.ranked[SHOWN : 20 * SHOWN]))
        more = f"and {len(found.sets) - len(shown)} more"
        if len(plan.ranked) < len(found.sets):
            more += f"; margins of the {len(plan.ranked)} shortest were looked at"
        yield Paragraph(plain(more))
        yield Details((rest,))


def _search(result: PlanResult) -> str:
    plan, found = result.plan, result.plan.found
    n, runs = len(plan.shared), counted(found.size, "run")
    reach = f"{found.rank} of {n}"
    finding = plan.stack.finding
    assert isinstance(finding, Analysis)
    if found.rank < finding.rank:
        reach += f" (all candidates together {finding.rank}, but some may not be combined)"
    if found.exhaustive:
        every = comb(len(plan.runs), found.size)
        which = (
            f"every set of {runs} does"
            if len(found.sets) == every
            else f"{len(found.sets)} of {every} sets do"
        )
        verb = "is" if found.size == 1 else "are"
        smaller = (
            f" No smaller set does: {found.looked_at} sets were tried, modulo a prime."
            if found.size > 1
            else ""
        )
        return f"{runs} {verb} the fewest that reach {reach}; {which}.{smaller}"
    guarantee = (
        "" if found.guarantee is None else f", at most {short(found.guarantee)} times the smallest number"
    )
    return f"{runs}, chosen one by one, reach {reach}{guarantee}: too many sets to try all."


def _set_row(one: RankedSet) -> tuple[Cell, ...]:
    margin = Text("–") if one.margin is None else Text(short(one.margin, 3), "good" if one.is_met else "bad")
    return (
        line(Text(" ".join(str(k + 1) for k in one.runs))),
        line(Text(f"{_minutes(one.duration)} min")),
        line(margin),
        line(Text("–" if one.shortest is None else f"{_minutes(one.needed)} min")),
    )


def _candidate_blocks(result: PlanResult) -> Iterator[Block]:
    plan = result.plan
    yield Heading(2, plain(f"Candidates ({len(plan.runs)})"))
    rows = tuple(
        (
            line(Text(str(k), "faint")),
            line(Text(one.run.name, "name")),
            line(Text(number(plan.durations[k - 1]))),
            line(Text(f"{len(one.rows)} of {len(plan.shared)}")),
        )
        for k, one in enumerate(plan.stack.runs, start=1)
    )
    yield Table(CANDIDATE_COLUMNS, rows)
    each = tuple(
        (
            line(Text(str(k), "faint")),
            combinations(one.rows, plan.stack.system) or line(Text("nothing", "faint")),
        )
        for k, one in enumerate(plan.stack.runs, start=1)
    )
    yield Details((Table((Column("#", "right"), Column("determines", breaks=True)), each),))


def _verdict_blocks(result: PlanResult) -> Iterator[Block]:
    yield Heading(2, plain("Verdict"))
    found, stack = result.verification, result.chosen
    n = len(result.plan.shared)
    if stack is None or not isinstance(stack.finding, Analysis):
        yield VerdictLine("open", plain("no plan"))
        return
    proof = f"proved exactly (generic): the plan determines {stack.finding.rank} of {n}"
    if isinstance(found, Verification):
        agree = f"{found.agree} of {len(found.points)} fractions of the runs"
        if found.verdict == "verified":
            yield VerdictLine("good", plain(f"{proof}; the Gramians agree at {agree}"))
        else:
            kind = "bad" if found.verdict == "contradicted" else "open"
            yield VerdictLine(kind, plain(f"{proof}; {found.verdict} by the Gramians: {found.reason}"))  # type: ignore[arg-type]
    else:
        reason = "" if found is None else f": {found.reason}"
        yield VerdictLine("open", plain(f"{proof}; not checked against the Gramians{reason}"))
    if result.accuracy is not None and result.accuracy.worst is not None:
        worst = result.accuracy.worst
        margin = f"worst margin {short(worst.margin, 3)} ({worst.name})"
        if worst.is_met:
            yield VerdictLine("good", plain(f"the plan meets all requirements, {margin}"))
        else:
            yield VerdictLine("bad", plain(f"the plan does not meet all requirements, {margin}"))


def _minutes(seconds: float) -> str:
    return short(seconds / 60, 3)
