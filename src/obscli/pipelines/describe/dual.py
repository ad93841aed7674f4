"""The report on a dual system in the words of controllability: one vocabulary for every section.

The sections speak of what outputs show. Of a dual the same findings say what inputs reach: combinations are
directions and directions combinations, observable is reachable. Names of the file are never touched.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Final

from obscli.core.document import (
    Block,
    Cell,
    Details,
    Heading,
    Inline,
    Listing,
    Math,
    Note,
    Paragraph,
    Table,
    Text,
    VerdictLine,
    plain,
)
from obscli.model.dual import is_constant
from obscli.model.system import System


#: Sentences and words of a report, and what takes their place, the longest first wherever two fit.
WORDS: Final[Mapping[str, str]] = {
    "observable combination": "reachable direction",
    "observable combinations": "reachable directions",
    "unobservable direction": "unreachable combination",
    "unobservable directions": "unreachable combinations",
    "unobservable states": "unreachable states",
    "observability matrix": "reachability matrix",
    "observable": "reachable",
    "unobservable": "unreachable",
    "reachable": "observable",
    "reachable and unobservable": "observable and unreachable",
    "reachable and observable": "observable and reachable",
    "detectable": "stabilizable",
    "combination": "direction",
    "combinations": "directions",
    "direction": "combination",
    "directions": "combinations",
    "hidden direction": "unreachable combination",
    "hidden directions": "unreachable combinations",
    "output": "input",
    "outputs": "inputs",
    "by inputs (B)": "by outputs (H)",
    "by disturbances (G)": "by outputs (H)",
    "combinations of two or more conditions": "combinations of two or more conditions",
    "the whole state is observable": "the inputs reach every state",
    "the outputs say nothing about the states": "the inputs move no state",
    "Change the states together in these proportions: no output shows it": "No input moves the combination "
    "of the states with these coefficients",
    "keeps its value along every solution": "the free state keeps a constant multiple of it",
    "contains moving states": "it does not",
    "that first yields it": "that first reaches it",
    "the order of its derivative": "the number of integrations",
    "known only in combination with": "moved only together with",
    "What no output shows moves": "What no input moves goes on",
    "nothing is hidden from the outputs": "the inputs reach everything",
    "every hidden error dies out": "what no input moves dies out",
    "what is hidden never dies out": "what no input moves never dies out",
    "no output shows it": "no input moves it",
}


def dual_blocks(system: System) -> Iterator[Block]:
    """Yield how to read the report, where a system is the dual of the file's."""
    if system.dual is None:
        return
    b, acting = ("B", "inputs") if system.dual == "B" else ("G", "disturbances (below: the inputs)")
    constant = is_constant(system)
    explained = (
        f"the observability of the dual system {_dual_equation(system)}, y = {b}ᵀ x, whose "
        f"{system.dynamics_name} and H "
        f"are meant below. A reachable direction (written as a sum) is one in which the {acting} move the "
        "state: an observable combination of the dual. An unreachable combination is one of the states that "
        "no input moves: an unobservable direction of the dual."
    )
    yield Paragraph((Text(f"Controllability of ({system.dynamics_name}, {b}): ", "strong"), Text(explained)))
    if not constant:
        text = "the system varies in time: whether what no input moves dies out is not asked of its dual"
        yield Note("note", plain(text))


def _dual_equation(system: System) -> str:
    if system.discrete:
        return f"x({system.time}+1) = Fᵀ x"
    return f"x′ = {'' if is_constant(system) else '−'}Aᵀ x"


def told_of(system: System, blocks: Iterable[Block]) -> Iterator[Block]:
    """Yield the blocks of a report in the words that fit a system, the same where it is no dual."""
    if system.dual is None:
        yield from blocks
        return
    vocabulary = _Vocabulary(system)
    yield from (vocabulary.block(block) for block in blocks)


class _Vocabulary:
    """Exchanges the words of texts, except for those that are names in the file."""

    def __init__(self, system: System) -> None:
        names = {system.time, *system.state_names, *(output.name for output in system.outputs)}
        names |= {parameter.name for parameter in system.parameters}
        names |= {function.name for function in system.functions}
        known = (words for words in WORDS if words not in names)
        longest_first = sorted(known, key=len, reverse=True)
        pattern = "|".join(map(re.escape, longest_first))
        self._pattern = re.compile(rf"(?<![\w*/^.])(?:{pattern})(?![\w*/^])", re.IGNORECASE)
        self._words = {words.lower(): new for words, new in WORDS.items()}

    def block(self, block: Block) -> Block:
        """Return a block in other words."""
        match block:
            case Table():
                columns = tuple(replace(one, title=self._text(one.title)) for one in block.columns)
                rows = tuple(tuple(self._cell(cell) for cell in row) for row in block.rows)
                return Table(columns, rows, self._inline(block.caption))
            case Listing():
                return replace(block, items=tuple(self._inline(item) for item in block.items))
            case Details():
                return Details(tuple(self.block(one) for one in block.blocks))
            case Heading() | Paragraph() | VerdictLine() | Note():
                return replace(block, content=self._inline(block.content))

    def _cell(self, cell: Cell) -> Cell:
        return tuple(self._inline(content) for content in cell)

    def _inline(self, content: Inline) -> Inline:
        return tuple(self._part(part) for part in content)

    def _part(self, part: Text | Math) -> Text | Math:
        if isinstance(part, Text) and part.role != "name":
            return replace(part, text=self._text(part.text))
        return part

    def _text(self, text: str) -> str:
        return self._pattern.sub(self._exchanged, text)

    def _exchanged(self, found: re.Match[str]) -> str:
        old = found.group()
        new = self._words[old.lower()]
        return new[0].upper() + new[1:] if old[0].isupper() else new
