"""Expressions that YAML split at their commas: ``[0, cross(a, b), 1]`` arrives in pieces."""

from __future__ import annotations

from obscli.model.tree import Node, Scalar
from obscli.model.trouble import Problems, shown


_HINT = 'inside [ ] and { } YAML splits at commas; write "…" around an expression that contains one'


def mend(items: list[Node], path: str, problems: Problems) -> dict[int, bool]:
    """Report the pieces of split expressions among the items of a flow collection.

    One report for each split expression, at its opening parenthesis. Returned are the positions of
    the pieces: True for a first one, False for those after it.
    """
    depth, found = 0, dict[int, bool]()
    for at, item in enumerate(items):
        if not isinstance(item, Scalar) or item.style:
            continue
        opening = first_open(item.text)
        change = item.text.count("(") - item.text.count(")")
        if depth == 0 and opening is not None and change > 0:
            message = f"quote this expression: '{shown(item.text)}' is only its first piece"
            problems.add(item.problem(path, message, _HINT, offset=opening, width=1))
            found[at] = True
        elif depth > 0:
            found[at] = False
        depth = max(0, depth + change)
    return found


def first_open(text: str) -> int | None:
    """Return where the first parenthesis stands that the text does not close."""
    stack: list[int] = []
    for at, character in enumerate(text):
        if character == "(":
            stack.append(at)
        elif character == ")" and stack:
            stack.pop()
    return stack[0] if stack else None
