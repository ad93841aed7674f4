"""How well one combination is known at the end, with what its error goes together, and what limits it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from obscli.core.document import Block, Note, Paragraph, plain
from obscli.core.number import short
from obscli.numeric.finding import Floor, Knowledge, NotComputed


FLOORS: Final[dict[Floor, tuple[str, str]]] = {
    "Q": ("driving noise", "without Q"),
    "R": ("noise of the outputs", "with a hundredth of R"),
    "P0": ("what was known before", "with a hundredth of P0"),
}


def number_blocks(known: Knowledge | NotComputed | None) -> Iterator[Block]:
    """Yield the standard deviation, the partners by correlation, and the floor; nothing without noise."""
    match known:
        case NotComputed(reason):
            yield Note("note", plain(f"no standard deviation: {reason}"))
        case Knowledge():
            yield Paragraph(plain(" ".join(_sentences(known))))
            if known.assumed:
                names = ", ".join(known.assumed)
                yield Note("note", plain(f"no prior in the file for {names}: taken as its scale, or 1"))


def _sentences(known: Knowledge) -> Iterator[str]:
    yield (
        f"Standard deviation: {short(known.before, 4)} at the start ({short(known.start, 6)}), "
        f"{short(known.after, 4)} at the end ({short(known.stop, 6)})."
    )
    if known.partners:
        parts = ", ".join(f"{name} ({short(rho, 2)})" for name, rho in known.partners)
        yield f"There its error goes with that of {parts}, by correlation."
    what, change = FLOORS[known.floor]
    left = short(known.without[known.floor], 2)
    yield f"Its floor is set by {what}: {change} it would be {left} of that."
