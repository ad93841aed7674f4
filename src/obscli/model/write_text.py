"""Pieces of a model file as text: numbers as people write them, quotes where YAML needs them.

Whatever is written here is read back as it was: expressions through ``to_text``, decimals exactly, every
other text in quotes unless its characters mean nothing to YAML.
"""

from __future__ import annotations

import re
import textwrap
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

from obscli.model.expression import (
    Expression,
    Number,
    Product,
    Symbol,
    children,
    negate,
    postorder,
    power,
    rebuild,
)
from obscli.model.notation import to_text


WIDEST: Final = 110
INDENT: Final = "  "

#: Names and expressions that YAML takes for one text, inside brackets too.
_PLAIN: Final = re.compile(r"(?:\w|\(|-(?=[\w(]))[\w +*/().^-]*(?<! )")
#: Words that are one text at the end of a line, though not inside brackets.
_PLAIN_LINE: Final = re.compile(r"[A-Za-z][^:#\"\\\x00-\x1f]*(?<! )")
_NULLS: Final = frozenset({"", "~", "null"})

#: A text already quoted, or entries in braces or below each other, or items in brackets.
Value: TypeAlias = "str | Sequence[Entry] | Items"
Entry: TypeAlias = "tuple[str, Value]"


@dataclass(frozen=True, slots=True)
class Items:
    """A list of texts already quoted, in one line or over several."""

    texts: tuple[str, ...]


def scalar(text: str) -> str:
    """Return a text that stands for itself anywhere in a YAML file."""
    is_whole = text.count("(") == text.count(")")  # an open one is taken for a piece of an expression
    if is_whole and _PLAIN.fullmatch(text) and text not in _NULLS:
        return text
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def formula(expression: Expression) -> str:
    """Return an expression, terminating decimals as such; v*v as v**2, as it is read back."""
    return scalar(to_text(with_decimals(_with_powers(expression))))


def _with_powers(expression: Expression) -> Expression:
    written: dict[int, Expression] = {}
    for node in postorder(expression):
        parts = tuple(written[id(part)] for part in children(node))
        if isinstance(node, Product):
            parts = _gathered(parts)
        written[id(node)] = rebuild(node, parts) if parts else node
    return written[id(expression)]


def _gathered(factors: tuple[Expression, ...]) -> tuple[Expression, ...]:
    """Return the factors with a name that stands there several times as a power, in its first place."""
    count = Counter(one.name for one in factors if isinstance(one, Symbol))
    found: list[Expression] = []
    for one in factors:
        if not isinstance(one, Symbol):
            found.append(one)
        elif one.name in count:
            found.append(power(one, count.pop(one.name)))
    return tuple(found)


def with_decimals(expression: Expression) -> Expression:
    """Return the expression with its tenths, hundredths, … in place of fractions: 9.81, not 981/100."""
    written: dict[int, Expression] = {}
    for node in postorder(expression):
        if isinstance(node, Number):
            text = _decimal(node)
            written[id(node)] = (
                node if text is None else negate(Symbol(text)) if node.value < 0 else Symbol(text)
            )
        else:
            parts = children(node)
            written[id(node)] = rebuild(node, tuple(written[id(part)] for part in parts)) if parts else node
    return written[id(expression)]


def _decimal(node: Number) -> str | None:
    """Return the size of a number in tenths, hundredths, …; None where it is whole, a half, or a third."""
    places = _places(node.value.denominator)
    if places is None:
        return None
    digits = str(abs(node.value.numerator) * 10**places // node.value.denominator)
    if len(digits) + 3 > places:
        digits = digits.zfill(places + 1)
        return f"{digits[:-places]}.{digits[-places:]}"
    fraction = f".{digits[1:]}" if len(digits) > 1 else ""
    return f"{digits[0]}{fraction}e{len(digits) - 1 - places}"


def _places(below: int) -> int | None:
    """Return how many decimals a denominator takes; None where it is a power of 2, or they never end."""
    twos = fives = 0
    while below % 2 == 0:
        below, twos = below // 2, twos + 1
    while below % 5 == 0:
        below, fives = below // 5, fives + 1
    return max(twos, fives) if below == 1 and fives else None


def entry_lines(key: str, value: Value, indent: str = "") -> list[str]:
    """Return ``key: value``, entries in braces where the line is short enough, else below each other."""
    start = f"{indent}{scalar(key)}:"
    line = f"{start} {_in_line(value)}"
    if isinstance(value, str) or not value or len(line) <= WIDEST:
        return [line]
    if isinstance(value, Items):
        return list_lines(key, value.texts, indent)
    return [start, *block_lines(value, indent + INDENT)]


def block_lines(entries: Iterable[Entry], indent: str = INDENT) -> list[str]:
    """Return entries below each other."""
    return [line for key, value in entries for line in entry_lines(key, value, indent)]


def _in_line(value: Value) -> str:
    if isinstance(value, str):
        return value
    if isinstance(value, Items):
        return f"[{', '.join(value.texts)}]"
    return "{" + ", ".join(f"{scalar(key)}: {_in_line(inner)}" for key, inner in value) + "}"


def list_lines(key: str, items: Sequence[str], indent: str = "") -> list[str]:
    """Return a list in brackets, over several lines where it is long."""
    line = f"{indent}{key}: [{', '.join(items)}]"
    if len(line) <= WIDEST:
        return [line]
    width = WIDEST - 4 - len(indent)
    body = textwrap.wrap(", ".join(items), width, break_long_words=False, break_on_hyphens=False)
    return [f"{indent}{key}: [", *(f"{indent}{INDENT}{part}" for part in body), f"{indent}]"]


def prose_lines(key: str, text: str) -> list[str]:
    """Return running text, folded where it is long."""
    text = " ".join(text.split())
    if len(key) + 2 + len(text) <= WIDEST:
        is_plain = _PLAIN_LINE.fullmatch(text) and text not in _NULLS
        return [f"{key}: {text if is_plain else scalar(text)}"]
    body = textwrap.wrap(text, WIDEST - 2, break_long_words=False, break_on_hyphens=False)
    return [f"{key}: >", *(INDENT + part for part in body)]
