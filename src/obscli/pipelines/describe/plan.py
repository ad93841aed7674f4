"""The report on a plan: what to do, minute by minute, what it reaches, and what nothing on offer can."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Final

from obscli.core.document import (
    Block,
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
from obscli.core.number import counted
from obscli.core.number import plain as number
from obscli.core.verification import Verification
from obscli.exact.finding import Analysis
from obscli.experiment.limits import MOST_ADDED, MOST_VARIED
from obscli.pipelines.describe.accuracy import required_blocks
from obscli.pipelines.describe.formulas import direction
from obscli.pipelines.describe.plan_sets import candidate_blocks, set_blocks
from obscli.pipelines.describe.shared import default_note, interval_note, shared_blocks
from obscli.pipelines.describe.words import minutes, ratio
from obscli.pipelines.plan_result import PlanResult


if TYPE_CHECKING:
    from obscli.experiment.ranking import RankedSet

SHOWN: Final = 10
STEP_COLUMNS: Final = (
    Column("#", "right"),
    Column("run", breaks=True),
    Column("lasts, min", "right"),
    Column("from, min", "right"),
    Column("to, min", "right"),
)
FACT_COLUMNS: Final = (Column(), Column(breaks=True))


def plan_document(results: Iterable[PlanResult]) -> Document:
    """Return the report on plans."""
    return Document(tuple(block for result in results for block in _blocks(result)))


def _blocks(result: PlanResult) -> Iterator[Block]:
    yield Heading(1, (Text(result.title),))
    if result.model.title:
        yield Paragraph((Text(result.model.title, "strong"),))
    plan = result.plan
    yield from shared_blocks(plan.shared, plan.fresh, plan.own)
    yield from default_note(result.is_default)
    yield from interval_note(plan.by_default)
    if plan.left_out:
        yield Note("note", plain(f"forbidden: {', '.join(plan.left_out)}"))
    for together in plan.not_together:
        yield Note("note", plain(f"not together: {', '.join(together)}"))
    yield from _chosen_blocks(result)
    if result.accuracy is not None:
        yield from required_blocks(result.accuracy)
        for note in result.accuracy.notes:
            yield Note("note", plain(note))
    elif result.model.require:
        yield Note("warning", plain(f"whether the requirements are met is open: {result.plan.no_accuracy}"))
    yield from _missing_blocks(result)
    yield from candidate_blocks(result)
    yield from set_blocks(result)
    yield from _verdict_blocks(result)


def _chosen_blocks(result: PlanResult) -> Iterator[Block]:
    """Yield the plan itself: runs one after the other, in minutes."""
    plan = result.plan
    chosen = plan.chosen
    yield Heading(2, plain("Plan"))
    if chosen is None:
        yield Paragraph(plain("No candidate determines anything of what is shared."))
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
                line(Text(minutes(lasts))),
                line(Text(minutes(at))),
                line(Text(minutes(at + lasts))),
            )
        )
        at += lasts
    total = f"{counted(len(chosen.runs), 'run')}, {minutes(at)} min in all"
    setup = f", {minutes(plan.setup_time)} min before each run to set it up" if plan.setup_time else ""
    caption = f"{total}{setup}; minutes if the unit of time is the second."
    yield Table(STEP_COLUMNS, tuple(rows), (Text(caption, "faint"),))
    yield from _how_chosen(result, chosen)


def _how_chosen(result: PlanResult, chosen: RankedSet) -> Iterator[Block]:
    plan = result.plan
    lines = []
    if plan.extended is not None:
        first = plan.ranked[0] if plan.ranked else None
        why = "would take longer" if first is not None and first.is_met else "do not meet what is required"
        lines.append(
            f"the smallest sets ({counted(plan.found.size, 'run')}) {why}; here runs were added one by one, "
            "each the one that brings the requirements nearest for its time, and those not needed left out"
        )
    if chosen.shortest is not None:
        steps = ", ".join(dict.fromkeys(number(step) for step in chosen.shortest.steps))
        lines.append(
            f"each run is as short as the requirements allow, in steps of {steps}: none can end a step "
            f"earlier while the others stay; at full length it would take {minutes(chosen.duration)} min"
        )
    elif chosen.margin is not None and not chosen.is_met:
        lines.append(f"no plan tried (up to {MOST_ADDED} runs) meets what is required")
    if lines:
        yield Listing(tuple(plain(one) for one in lines))


def _missing_blocks(result: PlanResult) -> Iterator[Block]:
    """Yield what no candidate can determine, and which kind of run would."""
    plan = result.plan
    finding = plan.there.finding
    assert isinstance(finding, Analysis)
    generic = plan.stack.finding
    if isinstance(generic, Analysis) and generic.rank > finding.rank:
        text = f"at your values all candidates determine {finding.rank}, at generic ones {generic.rank}"
        yield Note("warning", plain(text))
    if not finding.unobservable:
        return
    count = counted(len(finding.unobservable), "direction")
    yield Heading(2, plain(f"What no candidate can determine ({count})"))
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
        yield Paragraph(
            plain(f"With such runs added to the candidates (at most {MOST_VARIED} varied), modulo a prime:")
        )
        rows = tuple(
            (line(Text(one.words)), line(Text(f"{one.rank} of {n}"))) for one in plan.suggestions[:SHOWN]
        )
        yield Table((Column("kind of run", breaks=True), Column("rank", "right")), rows)
    elif plan.tried:
        yield Paragraph(
            plain(f"None of {counted(len(plan.tried), 'kind')} of runs tried would: turned, signs, angles, …")
        )
    tried = Listing(tuple(plain(one) for one in plan.tried))
    yield Details((Paragraph(plain("Tried:")), tried))


def _verdict_blocks(result: PlanResult) -> Iterator[Block]:
    yield Heading(2, plain("Verdict"))
    found, stack = result.verification, result.chosen
    n = len(result.plan.shared)
    if stack is None or not isinstance(stack.finding, Analysis):
        yield VerdictLine("open", plain("no plan"))
        return
    proof = f"proved exactly: the plan determines {stack.finding.rank} of {n} (generic)"
    if result.rank_at_values is not None and result.rank_at_values != stack.finding.rank:
        proof += f", at your values {result.rank_at_values}"
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
        margin = f"worst margin {ratio(worst.margin)} ({worst.name})"
        if worst.is_met:
            yield VerdictLine("good", plain(f"the plan meets all requirements, {margin}"))
        else:
            yield VerdictLine("bad", plain(f"the plan does not meet all requirements, {margin}"))
