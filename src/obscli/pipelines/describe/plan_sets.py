"""What there is to choose from, and the smallest sets that determine as much as possible."""

from __future__ import annotations

from collections.abc import Iterator
from math import comb
from typing import TYPE_CHECKING, Final

from obscli.core.document import (
    Block,
    Cell,
    Column,
    Details,
    Heading,
    Paragraph,
    Role,
    Table,
    Text,
    line,
    plain,
)
from obscli.core.number import counted, short
from obscli.exact.finding import Analysis
from obscli.pipelines.describe.formulas import combinations
from obscli.pipelines.describe.words import minutes, ratio
from obscli.pipelines.plan_result import PlanResult


if TYPE_CHECKING:
    from obscli.experiment.ranking import RankedSet

SHOWN: Final = 10
CANDIDATE_COLUMNS: Final = (
    Column("#", "right"),
    Column("candidate", breaks=True),
    Column("lasts, min", "right"),
    Column("determines", "right"),
)
SET_COLUMNS: Final = (Column("candidates", breaks=True), Column("takes, min", "right"))
MARGIN_COLUMNS: Final = (Column("worst margin", "right"), Column("shortened to, min", "right"))
TAKES: Final = "takes: all runs at full length, with setting up"
MARGIN: Final = (
    "; worst margin: the smallest of what is required over what is reached; shortened to: no run longer than "
    "the requirements need"
)


def set_blocks(result: PlanResult) -> Iterator[Block]:
    """Yield the smallest sets, ranked."""
    plan, found = result.plan, result.plan.found
    if not found.sets:
        return
    yield Heading(2, plain(f"Smallest sets ({counted(found.size, 'run')})"))
    yield Paragraph(plain(_search(result)))
    shown = plan.ranked[:SHOWN]
    asked = shown[0].margin is not None
    columns = (*SET_COLUMNS, *MARGIN_COLUMNS) if asked else SET_COLUMNS
    legend = f"{TAKES}{MARGIN if asked else ''}."
    yield Table(columns, tuple(_set_row(one) for one in shown), (Text(legend, "faint"),))
    if len(plan.ranked) > len(shown):
        rest = Table(columns, tuple(_set_row(one) for one in plan.ranked[SHOWN : 20 * SHOWN]))
        more = f"and {len(found.sets) - len(shown)} more"
        if len(plan.ranked) < len(found.sets):
            more += (
                f"; the margins of {len(plan.ranked)} were looked at, the best improved by exchanging runs"
            )
        yield Paragraph(plain(more))
        yield Details((rest,))


def _search(result: PlanResult) -> str:
    plan, found = result.plan, result.plan.found
    n, runs = len(plan.shared), counted(found.size, "run")
    reach = f"{found.rank} of {n}"
    finding = plan.there.finding
    assert isinstance(finding, Analysis)
    if found.rank < finding.rank:
        reach += f" (all candidates together {finding.rank}, but some may not be combined)"
    if found.exhaustive and found.size == 1:
        candidates = counted(len(plan.runs), "candidate")
        return f"1 run is enough for {reach}; {len(found.sets)} of {candidates} will do."
    if found.exhaustive:
        every = comb(len(plan.runs), found.size)
        which = f"{len(found.sets)} of {every} sets do"
        if plan.not_together:
            which = (
                f"{counted(len(found.sets), 'allowed set')} do"
                if len(found.sets) > 1
                else "1 allowed set does"
            )
        elif len(found.sets) == every:
            which = f"every set of {runs} does"
        looked = f"ranks modulo a prime, {found.looked_at} unions looked at"
        return f"{runs} are the fewest that reach {reach}; {which}. No smaller set does ({looked})."
    guarantee = (
        "" if found.guarantee is None else f", at most {short(found.guarantee)} times the smallest number"
    )
    return f"{runs}, chosen one by one, reach {reach}{guarantee}: too many sets to try all."


def _set_row(one: RankedSet) -> tuple[Cell, ...]:
    runs = (line(Text(" ".join(str(k + 1) for k in one.runs))), line(Text(minutes(one.duration))))
    if one.margin is None:
        return runs
    shortened = "–" if one.shortest is None else minutes(one.needed)
    role: Role = "good" if one.is_met else "bad"
    return (*runs, line(Text(ratio(one.margin), role)), line(Text(shortened)))


def candidate_blocks(result: PlanResult) -> Iterator[Block]:
    """Yield what there is to choose from."""
    plan = result.plan
    yield Heading(2, plain(f"Candidates ({len(plan.runs)})"))
    rows = tuple(
        (
            line(Text(str(k), "faint")),
            line(Text(one.run.name, "name")),
            line(Text(minutes(plan.durations[k - 1]))),
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
