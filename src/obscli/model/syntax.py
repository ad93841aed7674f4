"""The grammar: text to postfix steps, by operator precedence.

    sum:      a + b, a - b            left to right
    product:  a * b, a / b, a @ b     left to right
    sign:     -a, +a                  looser than the power: -x^2 = -(x^2)
    power:    a ^ b, a ** b           right to left: 2^3^2 = 2^(3^2)
    suffix:   M[i, j], v[i], M.T, f(a, b)

Postfix, so that evaluation needs no recursion: ``a + b*c`` becomes a b c * +.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Final, Literal, TypeAlias

from obscli.model.tokens import Mistake, Token, tokenize
from obscli.model.trouble import shown


DEEPEST: Final = 100
LONGEST: Final = 20_000
Operation: TypeAlias = Literal[
    "number", "name", "+", "-", "*", "/", "@", "^", "negate", "call", "index", "transpose", "list"
]
_BINDING: Final = {"+": 10, "-": 10, "*": 20, "/": 20, "@": 20, "^": 30, "**": 30}
_SIGN: Final = 25
_NOT_ANALYTIC_WORDS: Final = frozenset({"if", "else", "and", "or", "not"})


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """One operation of the postfix form, and where its word stands in the text."""

    operation: Operation
    offset: int
    width: int
    arity: int = 0
    text: str = ""
    value: Fraction | None = None


def parse(text: str) -> tuple[Step, ...]:
    """Return the postfix form of an expression.

    Raises
    ------
    Mistake
        where the text is no expression, with the offset
    """
    if not text.strip():
        raise Mistake(0, 1, "an expression is missing here")
    if len(text) > LONGEST:
        hint = "name its parts under `let`"
        raise Mistake(0, 1, f"an expression of {len(text):,} characters; at most {LONGEST:,} are read", hint)
    return _parse_short(text) if len(text) <= 40 else _Parser(text).whole()


@lru_cache(4096)
def _parse_short(text: str) -> tuple[Step, ...]:
    return _Parser(text).whole()


class _Parser:
    """Reads the tokens once, from left to right."""

    def __init__(self, text: str) -> None:
        self._tokens = tokenize(text)
        self._next = next(self._tokens)
        self._steps: list[Step] = []
        self._depth = 0

    def whole(self) -> tuple[Step, ...]:
        """Read one expression and the end."""
        self._expression(0)
        if self._next.kind != "end":
            raise self._unexpected(self._next)
        return tuple(self._steps)

    def _take(self) -> Token:
        token = self._next
        if token.kind != "end":
            self._next = next(self._tokens)
        return token

    def _emit(self, operation: Operation, token: Token, arity: int = 0) -> None:
        self._steps.append(Step(operation, token.offset, token.width, arity, token.text, token.value))

    def _expression(self, binding: int) -> None:
        self._depth += 1
        if self._depth > DEEPEST:
            hint = "name the inner parts under `let`"
            raise Mistake(self._next.offset, 1, f"the expression is nested over {DEEPEST} deep", hint)
        self._operand()
        self._rest(binding)
        self._depth -= 1

    def _rest(self, binding: int) -> None:
        while True:
            token = self._next
            if token.text in {"[", "."} and token.kind == "operator":
                self._suffix()
                continue
            power = _BINDING.get(token.text, 0) if token.kind == "operator" else 0
            if power == 0 or power < binding or (power == binding and power != 30):
                return
            self._take()
            self._expression(power)
            operation = "^" if token.text == "**" else token.text
            self._emit(operation, token, 2)  # type: ignore[arg-type]

    def _operand(self) -> None:
        token = self._take()
        match token.kind, token.text:
            case "number", _:
                self._emit("number", token)
            case "name", _:
                self._name(token)
            case "operator", "-":
                self._expression(_SIGN)
                self._emit("negate", token, 1)
            case "operator", "+":
                self._expression(_SIGN)
            case "operator", "(":
                self._expression(0)
                self._close(")", token)
            case "operator", "[":
                self._emit("list", token, self._arguments("]", token))
            case "end", _:
                raise Mistake(token.offset, 1, "the expression ends where a value is expected")
            case _:
                message = f"a value is expected here, not '{token.text}'"
                raise Mistake(token.offset, token.width, message, _nonfinite(token, self._next))

    def _name(self, token: Token) -> None:
        if self._next.text != "(" or self._next.kind != "operator":
            self._emit("name", token)
            return
        self._emit("call", token, self._arguments(")", self._take()))

    def _suffix(self) -> None:
        token = self._take()
        if token.text == "[":
            self._emit("index", token, 1 + self._arguments("]", token))
            return
        letter = self._take()
        if letter.text != "T":
            raise Mistake(token.offset, 1, "only '.T' (transpose) may follow a dot")
        self._emit("transpose", token, 1)

    def _arguments(self, closing: str, opening: Token) -> int:
        """Read expressions between commas up to the closing bracket; return how many."""
        count = 0
        while self._next.text != closing or self._next.kind == "end":
            self._expression(0)
            count += 1
            if self._next.text != ",":
                break
            self._take()
        self._close(closing, opening)
        return count

    def _close(self, closing: str, opening: Token) -> None:
        if self._next.kind == "end":
            raise Mistake(opening.offset, 1, f"this '{opening.text}' is never closed")
        if self._next.text != closing:
            raise self._unexpected(self._next)
        self._take()

    @staticmethod
    def _unexpected(token: Token) -> Mistake:
        if token.text in _NOT_ANALYTIC_WORDS:
            hint = "make the two cases two stages"
            return Mistake(
                token.offset, token.width, f"'{token.text}' makes an entry that is not analytic", hint
            )
        if token.kind in {"number", "name"} or token.text in {"(", "["}:
            message = f"an operator is missing before '{shown(token.text)}'"
            return Mistake(
                token.offset, token.width, message, "products are written with '*': 2*x, g*(a + b)"
            )
        if token.text in {")", "]"}:
            return Mistake(token.offset, 1, f"this '{token.text}' closes nothing")
        hint = "lists and rows are written in brackets: [0, 1]" if token.text == "," else ""
        return Mistake(token.offset, token.width, f"'{token.text}' is not expected here", hint)


def _nonfinite(token: Token, following: Token) -> str:
    """Return the advice for YAML's ``.inf`` and ``.nan``."""
    word = following.text.lower()
    return "numbers must be finite" if token.text == "." and word in {"inf", "nan"} else ""
