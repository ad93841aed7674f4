"""One combination of the states explained in words, on one screen."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Final

from obscli.checks.detectability import time_constant
from obscli.core.document import (
    Block,
    Details,
    Document,
    Heading,
    Inline,
    Kind,
    Listing,
    Math,
    Paragraph,
    Text,
    VerdictLine,
    plain,
)
from obscli.core.number import counted, short
from obscli.exact.finding import LinearFormVerdict, Undecided
from obscli.exact.structure_finding import Mode
from obscli.exact.trials import ChangeKind, Trial
from obscli.exact.why import Explanation
from obscli.model.system import Covector, System
from obscli.pipelines.describe.formulas import combination, direction
from obscli.pipelines.describe.structure import KINDS
from obscli.pipelines.describe.why_numbers import number_blocks
from obscli.pipelines.why_result import WhyResult


#: So many directions, combinations and names are printed, and formulas of this length; the rest with details.
MOST: Final = 3
MOST_NAMES: Final = 8
LONGEST: Final = 160

MEANING: Final[dict[LinearFormVerdict, str]] = {
    "observable": "the outputs determine it",
    "coupled": "the outputs determine it only together with other states",
    "unobservable": "no output depends on it, at any order",
    "undecided": "it could not be decided",
}
MOVES: Final = {
    "decaying": "dies out by itself",
    "neutral": "stays as it is",
    "growing": "grows by itself",
}
CHANGES: Final[dict[ChangeKind, str]] = {
    "output": "measured as well: ",
    "fix": "with a fix undone: ",
    "stage": "in another stage: ",
}


def why_document(results: Iterable[WhyResult]) -> Document:
    """Return the explanations, one after the other."""
    return Document(tuple(block for result in results for block in _blocks(result)))


def _blocks(result: WhyResult) -> Iterator[Block]:
    yield Heading(1, (Text(f"{result.target.name} in {result.title}"),))
    finding = result.finding
    if isinstance(finding, Undecided):
        yield VerdictLine("open", plain(f"undecided: {finding.reason}"))
        return
    there = finding.at_values
    yield _verdict(finding, "for generic values " if isinstance(there, Explanation) else "")
    yield from _reasons(finding)
    match there:
        case Explanation():
            because = f" because {', '.join(there.because)}" if there.because else ""
            yield _verdict(there, f"at the file's values (rank {there.rank}{because}) ")
            if there.verdict != finding.verdict:
                yield from _reasons(there)
        case Undecided():
            yield VerdictLine("info", plain(f"at the file's values: not known, {there.reason}"))
    yield from number_blocks(result.known)


def _verdict(finding: Explanation, where: str) -> VerdictLine:
    verdict = finding.verdict
    kind: Kind = KINDS.get(verdict, "open" if verdict == "undecided" else "bad")
    return VerdictLine(kind, plain(f"{where}{verdict}: {MEANING[verdict]}"))


def _reasons(finding: Explanation) -> Iterator[Block]:
    """Say what shows the target, what hides it, and what would help."""
    yield from _seen(finding)
    yield from _hidden(finding)
    if finding.verdict in {"coupled", "unobservable"}:
        yield from _remedies(finding)


def _seen(finding: Explanation) -> Iterator[Block]:
    """Say which output shows the target, or what shows the combinations it enters."""
    if finding.seen_by is not None:
        output, order = finding.seen_by
        yield Paragraph((Text("First shown by "), Text(output, "name"), Text(_order(order, finding.system))))
    if finding.combinations:
        together = f", together with {_names(finding.group)}" if finding.group else ""
        yield Paragraph(plain(f"The outputs show{together}:"))
        shown = [(_combination(one.coefficients, finding), one) for one in finding.combinations]
        shown.sort(key=lambda one: len(one[0][0].text))
        origins = [f"  ({one.output}, order {one.order})" for _, one in shown]
        yield from _listed([formula for formula, _ in shown], origins)
    if finding.corrections and not _is_listed(finding):
        one_of = "The smallest observable combination with it:"
        many = "The smallest changes of it that are observable:"
        yield Paragraph(plain(one_of if len(finding.target.coefficients) == 1 else many))
        yield from _listed([_combination(one, finding) for one in finding.corrections])


def _is_listed(finding: Explanation) -> bool:
    """Whether a smallest correction is among the combinations of the basis."""
    supports = [one.coefficients.keys() for one in finding.combinations]
    single = len(finding.target.coefficients) == 1
    return single and any(one.keys() == support for one in finding.corrections for support in supports)


def _order(order: int, system: System) -> str:
    if system.discrete:
        return {0: " itself.", 1: " and its next sample."}.get(order, f" and its next {order} samples.")
    return {0: " itself.", 1: " and its derivative."}.get(order, f" and its derivatives up to order {order}.")


def _hidden(finding: Explanation) -> Iterator[Block]:
    """Say along which directions the target changes unseen, and how these move."""
    if not finding.directions:
        return
    count = counted(len(finding.directions), "direction")
    yield Paragraph(plain(f"It changes along {count} of the state that no output shows:"))
    shown = [(direction(one, finding.system), one) for one in finding.directions]
    yield from _listed(sorted(shown, key=lambda one: len(one[0].text)))
    moves = list(dict.fromkeys(_moves(mode) for mode in finding.modes))
    if finding.moving:
        moves.append("moves in a way that depends on time (obscli analyze --only structure follows it)")
    if moves:
        yield Paragraph(plain(f"Its hidden error {', or '.join(moves)}."))


def _moves(mode: Mode) -> str:
    """Say how a mode moves: at the file's values where it depends on them."""
    kind = mode.kind_there if mode.kind == "depends" else mode.kind
    condition = f"dies out iff {mode.condition}" if mode.condition else "moves by itself"
    time = time_constant(mode)
    unit = " steps" if mode.discrete else ""
    pace = (
        "" if time is None else f", {'to 1/e' if kind == 'decaying' else 'e-fold'} in {short(time, 3)}{unit}"
    )
    driven = ", driven by others" if mode.chained else ""
    return f"{MOVES.get(kind, condition)} (eigenvalue {mode.eigenvalue}{pace}{driven})"


def _remedies(finding: Explanation) -> Iterator[Block]:
    """Say what would make the target observable."""
    lines = [_remedy(kind, finding) for kind in CHANGES]
    if finding.remedies:
        yield Paragraph(plain(f"It becomes observable (rank {finding.rank} now):"))
        yield Listing(tuple(line for line in lines if line))
    else:
        tried = "one more measured state, a fix undone, another stage of the file"
        yield Paragraph(plain(f"No single change makes it observable (tried: {tried})."))
    if finding.open:
        yield Paragraph(plain(f"Not decided: {', '.join(one.change for one in finding.open)}."))


def _remedy(kind: ChangeKind, finding: Explanation) -> Inline:
    found = [one for one in finding.remedies if one.kind == kind]
    if not found:
        return ()
    parts: list[Text | Math] = [Text(CHANGES[kind])]
    for k, one in enumerate(found[:MOST_NAMES]):
        itself = " itself" if kind == "output" and one.change == finding.target.name else ""
        parts += [Text(", ")] if k else []
        parts += [Text(one.change, "name"), Text(f"{itself} ({_rank(one)})")]
    if len(found) > MOST_NAMES:
        rest = found[MOST_NAMES:]
        parts.append(Text(f"; tried modulo a prime, not proved: {_names([one.change for one in rest])}"))
    return tuple(parts)


def _rank(one: Trial) -> str:
    return f"rank {one.rank}" if one.proved else f"rank {one.rank} modulo a prime, not proved"


def _names(names: Sequence[str]) -> str:
    shown, rest = names[:MOST_NAMES], len(names) - MOST_NAMES
    return ", ".join(shown) + (f" and {rest} more" if rest > 0 else "")


#: A formula and the states in it.
_Formula = tuple[Math, Covector]


def _combination(covector: Covector, finding: Explanation) -> _Formula:
    return combination(covector, finding.system), covector


def _listed(found: Sequence[_Formula], notes: Sequence[str] = ()) -> Iterator[Block]:
    """Yield formulas as a list: the first ones, the long ones by their states; all of them as details."""
    marks: list[Inline] = [(Text(note, "faint"),) for note in notes] or [()] * len(found)
    full: list[Inline] = [(formula, *mark) for (formula, _), mark in zip(found, marks, strict=True)]
    brief: list[Inline] = [(_brief(*one), *mark) for one, mark in zip(found[:MOST], marks, strict=False)]
    rest = len(found) - MOST
    more = [plain(f"and {rest} more (--details)")] if rest > 0 else []
    yield Listing((*brief, *more))
    if full != brief:
        yield Details((Paragraph(plain("In full:")), Listing(tuple(full))))


def _brief(formula: Math, states: Covector) -> Text | Math:
    """Return the formula, or where it is long the states in it."""
    if len(formula.text) <= LONGEST:
        return formula
    return Text(f"one with {_names(list(states))} (--details)", "faint")
