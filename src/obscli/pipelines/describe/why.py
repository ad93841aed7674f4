"""One combination of the states explained in words, on one screen."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Final

from obscli.core.document import (
    Block,
    Document,
    Heading,
    Inline,
    Kind,
    Listing,
    Math,
    Note,
    Paragraph,
    Text,
    VerdictLine,
    plain,
)
from obscli.core.number import counted, short
from obscli.exact.finding import LinearFormVerdict, Undecided
from obscli.exact.why import Explanation, Remedy
from obscli.numeric.finding import Floor, Knowledge, NotComputed
from obscli.pipelines.describe.formulas import combination, direction
from obscli.pipelines.describe.structure import KINDS
from obscli.pipelines.why_result import WhyResult


#: So many directions and combinations are printed; more are counted.
MOST: Final = 4

MEANING: Final[dict[LinearFormVerdict, str]] = {
    "observable": "the outputs determine it",
    "coupled": "the outputs determine it only together with other states",
    "unobservable": "no output depends on it, at any order",
    "undecided": "it could not be decided",
}
FLOORS: Final[dict[Floor, str]] = {
    "Q": "the driving noise (Q): without it",
    "R": "the noise of the outputs (R): with a hundredth of it",
    "P0": "what was known before (P0): with a hundredth of it",
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
    yield VerdictLine(_kind(finding.verdict), plain(f"{finding.verdict}: {MEANING[finding.verdict]}"))
    yield from _reasons(finding)
    if finding.at_values is not None:
        yield VerdictLine(*_at_values(finding.at_values))
    if result.there is not None:
        yield from _reasons(result.there)
    yield from _known(result)


def _reasons(finding: Explanation) -> Iterator[Block]:
    yield from _seen(finding)
    yield from _hidden(finding)
    if finding.verdict in {"coupled", "unobservable"}:
        yield from _remedies(finding)


def _kind(verdict: LinearFormVerdict) -> Kind:
    return KINDS.get(verdict, "open" if verdict == "undecided" else "bad")


def _at_values(there: Remedy) -> tuple[Kind, Inline]:
    because = f" ({there.change})" if there.change else ""
    return _kind(there.becomes), plain(f"at the file's values{because}: {there.becomes}, rank {there.rank}")


def _seen(finding: Explanation) -> Iterator[Block]:
    """Say which output shows the target, or what shows the combinations it enters."""
    if finding.seen_by is not None:
        output, order = finding.seen_by
        yield Paragraph((Text("First shown by "), Text(output, "name"), Text(_order(order))))
    if finding.combinations:
        yield Paragraph(plain(f"The outputs show, together with {', '.join(finding.group)}:"))
        yield _list(
            [
                (
                    combination(one.coefficients, finding.system),
                    Text(f"  ({one.output}, order {one.order})", "faint"),
                )
                for one in finding.combinations
            ]
        )
    if finding.corrections and len(finding.target.coefficients) > 1:
        yield Paragraph(plain("The smallest change of it that is observable:"))
        yield _list([(combination(one, finding.system),) for one in finding.corrections])


def _order(order: int) -> str:
    return {0: " itself.", 1: " and its derivative."}.get(order, f" and its derivatives up to order {order}.")


def _hidden(finding: Explanation) -> Iterator[Block]:
    """Say along which directions the target changes unseen, and how these move."""
    if not finding.directions:
        return
    count = counted(len(finding.directions), "direction")
    yield Paragraph(plain(f"It changes along {count} of the state that no output shows:"))
    yield _list([(direction(one, finding.system),) for one in finding.directions])
    kinds = dict.fromkeys(f"{mode.kind_there} (eigenvalue {mode.eigenvalue})" for mode in finding.modes)
    if kinds:
        yield Paragraph(plain(f"Its hidden error is {', '.join(kinds)}."))


def _remedies(finding: Explanation) -> Iterator[Block]:
    """Say what would make the target observable."""
    if not finding.remedies:
        tried = "one more measured state, a fix undone, another stage of the file"
        yield Paragraph(plain(f"No single change makes it observable (tried: {tried})."))
        return
    yield Paragraph(plain("It becomes observable:"))
    lines = [_remedy(kind, finding.remedies) for kind in ("output", "fix", "stage")]
    yield Listing(tuple(line for line in lines if line))


def _remedy(kind: str, remedies: Iterable[Remedy]) -> Inline:
    found = [one for one in remedies if one.kind == kind]
    if not found:
        return ()
    intro = {"output": "measured as well: ", "fix": "with a fix undone: ", "stage": "in another stage: "}[
        kind
    ]
    parts: list[Text | Math] = [Text(intro)]
    for k, one in enumerate(found):
        parts += [Text(", ")] if k else []
        parts += [Text(one.change, "name"), Text(f" (rank {one.rank}{'' if one.proved else ', not proved'})")]
    return tuple(parts)


def _known(result: WhyResult) -> Iterator[Block]:
    """Say how well the target is known, what its error goes with, and what limits it."""
    known = result.known
    if isinstance(known, NotComputed):
        yield Note("note", plain(f"no standard deviation: {known.reason}"))
    if not isinstance(known, Knowledge):
        return
    span = f"from {short(known.start, 6)} to {short(known.stop, 6)}"
    yield Paragraph(
        plain(f"Standard deviation {span}: {short(known.before, 4)} before, {short(known.after, 4)} after.")
    )
    if known.partners:
        parts = ", ".join(f"{name} ({short(rho, 2)})" for name, rho in known.partners)
        yield Paragraph(plain(f"At the end its error goes with that of {parts} (correlation)."))
    if known.floor == "none":
        yield Paragraph(
            plain("No single noise limits it: a hundredth of R or P0, or no Q, lowers it little.")
        )
    else:
        lower = short(known.without[known.floor], 2)
        yield Paragraph(plain(f"It is limited by {FLOORS[known.floor]} it would be {lower} times that."))
    if known.assumed:
        yield Note(
            "note", plain(f"no prior in the file for {', '.join(known.assumed)}: taken as its scale, or 1")
        )


def _list(items: list[Inline]) -> Listing:
    rest = len(items) - MOST
    more: tuple[Inline, ...] = ((Text(f"and {rest} more", "faint"),),) if rest > 0 else ()
    return Listing((*items[:MOST], *more))
