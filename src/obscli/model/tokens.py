"""The words of an expression, each with its offset.

Names are letters of any script, digits and underscores (normalised to NFC); numbers are exact.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Final, Literal, TypeAlias


LONGEST_NUMBER: Final = 1000
LARGEST_EXPONENT: Final = 400
LONGEST_NAME: Final = 64
Kind: TypeAlias = Literal["number", "name", "operator", "end"]

_NUMBER: Final = re.compile(r"(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_PLAIN_NAME: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,63}(?![A-Za-z0-9_]|[^\x00-\x7f])")
_OPERATORS: Final = ("**", "+", "-", "*", "/", "^", "@", "(", ")", "[", "]", ",", ".")
_ADVICE: Final = {
    "<": "comparisons and if/else are not analytic; make the two cases two stages",
    ">": "comparisons and if/else are not analytic; make the two cases two stages",
    "=": "an expression is a value: no '=' in it",
    "!": "factorials are not read: write the number",
    "?": "comparisons and if/else are not analytic; make the two cases two stages",
    "{": "lists are written with [ ], precedence with ( )",
    "'": "a name followed by ' is no derivative; write deriv(f)",
    "’": "a name followed by ’ is no derivative; write deriv(f)",
    "−": "this is a typographic minus; write '-'",
    "–": "this is a dash; write '-'",
    "×": "write '*', or cross(a, b)",
    "·": "write '*', or dot(a, b)",
    "⋅": "write '*', or dot(a, b)",
    "√": "write sqrt(x)",
    "²": "write x^2",
    "³": "write x^3",
    "°": "write angles in radians, as 30*pi/180",
    "%": "write 5/100",
}


@dataclass(frozen=True, slots=True)
class Token:
    """One word: what it is, its text, where it begins."""

    kind: Kind
    text: str
    offset: int
    width: int
    value: Fraction | None = None


class Mistake(Exception):  # noqa: N818
    """Something wrong in an expression's text, at an offset of it."""

    def __init__(self, offset: int, width: int, message: str, hint: str = "") -> None:
        self.offset, self.width, self.message, self.hint = offset, width, message, hint
        super().__init__(message)


def tokenize(text: str) -> Iterator[Token]:
    """Yield the words of the text, an ``end`` last."""
    at = 0
    while at < len(text):
        if text[at] in " \t\r\n":
            at += 1
            continue
        token = _number(text, at) or _name(text, at) or _operator(text, at)
        yield token
        at += token.width
    yield Token("end", "", len(text.rstrip()), 1)


def _number(text: str, at: int) -> Token | None:
    match = _NUMBER.match(text, at)
    if match is None:
        return None
    word = match[0]
    return Token("number", word, at, len(word), exact(word, at))


def exact(word: str, at: int = 0) -> Fraction:
    """Return the decimal literal as a rational number."""
    mantissa, _, exponent = word.lower().partition("e")
    if len(mantissa) > LONGEST_NUMBER:
        raise Mistake(at, len(word), f"a number of {len(mantissa)} digits; at most {LONGEST_NUMBER} are read")
    if len(exponent) > 6 or abs(int(exponent or 0)) > LARGEST_EXPONENT:
        message = f"the exponent of this number is beyond ±{LARGEST_EXPONENT}"
        raise Mistake(at, len(word), message)
    if len(mantissa) > 1 and mantissa[0] == "0" and mantissa[1].isdigit():
        hint = "octal numbers are not read; delete the zeros in front"
        raise Mistake(at, len(word), "a number does not begin with 0 and another digit", hint)
    return Fraction(word if word[-1] != "." else word + "0")


def _is_start(character: str) -> bool:
    return character == "_" or character.isalpha()


def _is_part(character: str) -> bool:
    return _is_start(character) or character.isdecimal() or unicodedata.category(character) in {"Mn", "Mc"}


def _name(text: str, at: int) -> Token | None:
    plain = _PLAIN_NAME.match(text, at)
    if plain is not None:
        return Token("name", plain[0], at, len(plain[0]))
    if not _is_start(text[at]):
        return None
    end = at + 1
    while end < len(text) and _is_part(text[end]):
        end += 1
    word = unicodedata.normalize("NFC", text[at:end])
    if len(word) > LONGEST_NAME:
        raise Mistake(at, end - at, f"a name of {len(word)} letters; at most {LONGEST_NAME} are read")
    return Token("name", word, at, end - at)


def is_name(text: str) -> bool:
    """Whether the text can name something."""
    if _PLAIN_NAME.fullmatch(text):
        return True
    fits = bool(text) and len(text) <= LONGEST_NAME
    return fits and _is_start(text[0]) and all(_is_part(character) for character in text)


def _operator(text: str, at: int) -> Token:
    for operator in _OPERATORS:
        if text.startswith(operator, at):
            return Token("operator", operator, at, len(operator))
    character = text[at]
    raise Mistake(
        at, 1, f"the character '{character}' has no meaning in an expression", _ADVICE.get(character, "")
    )
