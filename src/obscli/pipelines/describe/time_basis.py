"""The basis as the Gramian shows it, with the guessed form of every coefficient."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from obscli.core.document import (
    Block,
    Cell,
    Column,
    Details,
    Heading,
    Inline,
    Math,
    Note,
    Paragraph,
    Role,
    Table,
    Text,
    line,
    plain,
)
from obscli.core.number import short
from obscli.model.notation import decimal_text, to_latex, to_text
from obscli.numeric.finding import CoefficientCurve, EchelonFinding, NumericFinding
from obscli.pipelines.latex_names import latex_names
from obscli.pipelines.stage_result import StageResult


COLUMNS: Final = (
    Column("combination of"),
    Column("with"),
    Column("coefficient", breaks=True),
    Column("residual", "right"),
    Column("held back", "right"),
    Column(),
)
LEGEND: Final = (
    "Each combination is its first state plus the others with their coefficients. guess: the form fits "
    "within the error, also at the third of the instants held back; proved: algebra gives the same."
)
ROLES: Final[dict[str, Role]] = {
    "proved": "good",
    "guess": "open",
    "refuted": "bad",
    "not identified": "open",
}


def time_basis_blocks(result: StageResult) -> Iterator[Block]:
    """Yield the coefficients with their guesses, open where the numerical side is alone."""
    found = result.basis
    if found is None:
        return
    blocks = tuple(_blocks(found, result))
    if result.shown == "numeric":
        yield from blocks
    else:
        yield Details(blocks)


def _blocks(found: EchelonFinding, result: StageResult) -> Iterator[Block]:
    yield Heading(2, plain("Combinations as the Gramian shows them"))
    numeric = result.numeric
    if isinstance(numeric, NumericFinding) and numeric.signals is not None and numeric.signals.is_noise:
        yield Note("note", plain("what noise of the signals alone would show is among them: see Signals"))
    coupled = {one.pivot for one in found.curves}
    alone = [pivot for pivot in found.pivots if pivot not in coupled]
    if found.curves:
        rows = tuple(_rows(found, result))
        yield Table(COLUMNS, rows, (Text(LEGEND, "faint"),))
    if alone:
        yield Paragraph((Text("By themselves: "), *(Text(f"{name} ", "name") for name in alone)))


def _rows(found: EchelonFinding, result: StageResult) -> Iterator[tuple[Cell, ...]]:
    pivot = ""
    for one in found.curves:
        guess = one.guess
        yield (
            line(Text("" if one.pivot == pivot else one.pivot, "name")),
            line(Text(one.free, "name")),
            (_form(one, result),),
            line(Text("–" if guess.residual is None else short(guess.residual))),
            line(Text("–" if guess.held_back is None else short(guess.held_back))),
            line(Text(one.standing, ROLES[one.standing])),
        )
        pivot = one.pivot


def _form(one: CoefficientCurve, result: StageResult) -> Inline:
    expression = one.guess.expression
    if expression is None:
        low, high = min(one.values), max(one.values)
        return (Text(f"from {short(low, 4)} to {short(high, 4)} ({one.guess.reason})"),)
    text = decimal_text(expression) if one.guess.in_digits else to_text(expression)
    return (Math(text, to_latex(expression, latex_names(result.system))),)
