"""Text from a file made safe to show: nothing in it can move the cursor, hide or reorder what is read."""

from __future__ import annotations

import unicodedata
from typing import Final


#: Control, format (bidi overrides, zero width), surrogate, private, unassigned, line and paragraph separator.
HIDDEN: Final = frozenset({"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"})


def visible(text: str, keep: str = "") -> str:
    r"""Return the text with every invisible or controlling character, except ``keep``, spelt as an escape.

    >>> visible("a\x1b[31m")
    'a\\x1b[31m'
    """
    if text.isascii() and text.isprintable():
        return text
    return "".join(
        character if character in keep or unicodedata.category(character) not in HIDDEN else _spelt(character)
        for character in text
    )


def _spelt(character: str) -> str:
    return character.encode("unicode_escape").decode("ascii")
