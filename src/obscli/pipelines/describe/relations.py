"""The method of unobservable states: which relations f(t) dᵀx0 = 0 say that no output shows x0."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from obscli.core.document import (
    Block,
    Cell,
    Column,
    Details,
    Heading,
    Listing,
    Math,
    Note,
    Paragraph,
    Table,
    Text,
    line,
    plain,
)
from obscli.core.number import counted
from obscli.exact.relations_finding import Canonical, Relation, Relations, Situation
from obscli.model.expression import Expression, Symbol, add, multiply, power
from obscli.model.notation import to_latex, to_text
from obscli.model.system import System
from obscli.pipelines.describe.formulas import combination
from obscli.pipelines.describe.words import names
from obscli.pipelines.latex_names import latex_names


COLUMNS: Final = (Column("function"), Column("relation", breaks=True), Column("output"))
SITUATION_COLUMNS: Final = (Column(align="right"), Column(), Column(align="right"), Column(breaks=True))
SITUATIONS: Final[dict[Situation, str]] = {
    1: "zero by the relations alone",
    2: "tied to others by relations",
    3: "in no relation",
}


def relation_blocks(relations: Relations, system: System) -> Iterator[Block]:
    """Yield, as details, the independent relations, the situation of each state, and what limits them."""
    yield Details(tuple(_blocks(relations, system)))


def _blocks(relations: Relations, system: System) -> Iterator[Block]:
    yield Heading(2, plain("Method of unobservable states"))
    yield Paragraph(plain(_introduction(relations, system)))
    shown = [one for one in relations.relations if one.independent]
    if shown:
        yield Table(
            COLUMNS, tuple(_row(one, system) for one in shown), _caption(relations, system, len(shown))
        )
    if relations.canonical:
        yield Listing(tuple(plain(_meaning(one)) for one in relations.canonical))
    yield Table(SITUATION_COLUMNS, tuple(_situations(relations)))
    if relations.differing:
        yield Note("note", plain(_differing(relations)))
    for note in relations.notes:
        yield Note("note", plain(note))


def _introduction(relations: Relations, system: System) -> str:
    time = system.time
    if relations.exact:
        return (
            f"Every output is a sum of terms f({time}) dᵀx0, x0 the state at {time} = 0 and the functions f "
            "independent: no output shows x0 exactly if dᵀx0 = 0 in every term."
        )
    assert relations.instant is not None
    return (
        f"Every output is a power series of terms f({time}) dᵀx0, x0 the state at {time} = "
        f"{to_text(relations.instant)}: no output shows x0 exactly if dᵀx0 = 0 in every term. Those below "
        "suffice. (That derivatives below order n do is certain at generic instants only.)"
    )


def _caption(relations: Relations, system: System, shown: int) -> tuple[Text, ...]:
    rest = len(relations.relations) - shown
    follow = "follows" if rest == 1 else "follow"
    more = f" {counted(rest, 'more relation')} {follow} from these." if rest else ""
    where = ", at generic values of the parameters" if system.parameters else ""
    return (Text(f"d up to a factor{where}.{more}", "faint"),)


def _row(one: Relation, system: System) -> tuple[Cell, ...]:
    return (
        line(_formula(one.function, system)),
        line(combination(one.combination, system)),
        line(Text(one.output, "name")),
    )


def _formula(expression: Expression, system: System) -> Math:
    return Math(to_text(expression), to_latex(expression, latex_names(system)))


def _meaning(one: Canonical) -> str:
    """Say what the names of canonical solutions mean."""
    s = Symbol("s")
    terms = [multiply(c, power(s, k)) for k, c in enumerate(one.polynomial)]
    polynomial = to_text(add(*reversed(terms)))
    return (
        f"{', '.join(one.names)}: the solutions of q(d/dt) f = 0, q(s) = {polynomial}, which begin at 0 with "
        f"one derivative 1, of order 0 to {len(one.names) - 1} in turn, and the others below order "
        f"{len(one.names)} zero"
    )


def _situations(relations: Relations) -> Iterator[tuple[Cell, ...]]:
    for situation, words in SITUATIONS.items():
        members = tuple(state for state, one in relations.situations.items() if one == situation)
        if members:
            yield (
                line(Text(str(situation))),
                line(Text(words)),
                line(Text(str(len(members)))),
                (names(members),),
            )


def _differing(relations: Relations) -> str:
    assert relations.instant is not None
    return (
        f"At the instant {to_text(relations.instant)} the situation of {', '.join(relations.differing)} is "
        "another than at almost every instant, to which the verdicts on the states apply."
    )
