"""Reading the keys of a mapping: unknown ones are errors, texts and lists are checked for being such."""

from __future__ import annotations

import unicodedata
from collections.abc import Collection
from collections.abc import Mapping as MappingOf

from obscli.model.catalogue import RESERVED
from obscli.model.tokens import is_name
from obscli.model.tree import Broken, Mapping, Node, Scalar, Sequence, kind
from obscli.model.trouble import Problems, nearest, shown


def fields(
    node: Node | None, path: str, known: Collection[str] | None, problems: Problems
) -> dict[str, tuple[Scalar, Node]]:
    """Return the entries of a mapping by key; other kinds of node and unknown keys are reported.

    Parameters
    ----------
    known : the keys allowed, None where they are names of the user
    """
    if node is None or isinstance(node, Broken) or (isinstance(node, Scalar) and node.is_null):
        return {}
    if not isinstance(node, Mapping):
        problems.add(node.problem(path, f"a mapping of names to values is expected here, not {kind(node)}"))
        return {}
    found: dict[str, tuple[Scalar, Node]] = {}
    for key, value in node.entries:
        if known is not None and key.text not in known:
            message = f"unknown key '{shown(key.text)}'{nearest(key.text, known)}"
            problems.add(
                key.problem(path, message, f"keys here: {', '.join(known)}" if len(known) <= 16 else "")
            )
        else:
            found[unicodedata.normalize("NFC", key.text)] = (key, value)
    return found


def name_of(key: Scalar, path: str, problems: Problems) -> str | None:
    """Return the name a key or list item gives, None (reported) where it is none or reserved."""
    name = unicodedata.normalize("NFC", key.text)
    if not is_name(name):
        hint = "write a space after the colon" if ":" in name else ""
        message = (
            f"'{shown(name)}' is no name: letters, digits and underscores, not a digit first, at most 64"
        )
        problems.add(key.problem(path, message, hint))
        return None
    if name in RESERVED:
        what = "the number π" if name == "pi" else "a function"
        problems.add(
            key.problem(path, f"'{name}' is reserved: it is {what} in expressions; choose another name")
        )
        return None
    return name


def text_of(entry: tuple[Scalar, Node] | None, path: str, problems: Problems) -> str:
    """Return the text of an entry; lists and mappings are reported."""
    if entry is None or isinstance(entry[1], Broken):
        return ""
    node = entry[1]
    if not isinstance(node, Scalar):
        problems.add(node.problem(path, f"a text is expected here, not {kind(node)}"))
        return ""
    return "" if node.is_null else " ".join(node.text.split())


def choice_of(
    entry: tuple[Scalar, Node] | None, path: str, choices: Collection[str], problems: Problems
) -> str:
    """Return the text of an entry, which must be one of the choices; "" where absent or wrong."""
    text = text_of(entry, path, problems)
    if text and text not in choices and entry is not None:
        message = f"'{shown(text)}' is none of {', '.join(choices)}{nearest(text, choices)}"
        problems.add(entry[1].problem(path, message))
        return ""
    return text


def whole_of(node: Node, path: str, problems: Problems, *, least: int = 1, most: int = 5000) -> int | None:
    """Return a whole number from ``least`` to ``most``, None (reported) where it is none."""
    if isinstance(node, Broken):
        return None
    text = node.text if isinstance(node, Scalar) else ""
    plain = text.isascii() and text.isdigit() and len(text) < 9 and (text == "0" or text[0] != "0")
    if plain and least <= int(text) <= most:
        return int(text)
    found = f"'{shown(text)}'" if isinstance(node, Scalar) else kind(node)
    problems.add(node.problem(path, f"a whole number from {least} to {most} is expected here, not {found}"))
    return None


def items_of(node: Node, path: str, problems: Problems) -> tuple[Node, ...]:
    """Return the items of a list; other kinds of node are reported."""
    if isinstance(node, Sequence):
        return node.items
    if not isinstance(node, Broken):
        problems.add(node.problem(path, f"a list is expected here, not {kind(node)}"))
    return ()


Fields = MappingOf[str, tuple[Scalar, Node]]
