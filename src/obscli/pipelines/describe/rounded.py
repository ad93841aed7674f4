"""Numbers of many digits rounded for a reader, in formulas that are exact elsewhere."""

from __future__ import annotations

from typing import Final

from obscli.model.expression import Expression, Number, Symbol, children, negate, postorder, rebuild
from obscli.model.system import Covector


#: A fraction with a whole number above this over or under the line is rounded.
_LARGEST: Final = 10**9
_DIGITS: Final = 9


def rounded(form: Covector) -> tuple[Covector, dict[str, str]]:
    """Return a linear form with its long fractions as decimals, and the LaTeX of these by their text."""
    numerals: dict[str, str] = {}
    return {state: _rounded(entry, numerals) for state, entry in form.items()}, numerals


def _rounded(expression: Expression, numerals: dict[str, str]) -> Expression:
    written: dict[int, Expression] = {}
    for node in postorder(expression):
        parts = children(node)
        new = rebuild(node, tuple(written[id(part)] for part in parts)) if parts else node
        if isinstance(node, Number) and max(abs(node.value.numerator), node.value.denominator) > _LARGEST:
            new = _decimal(node, numerals)
        written[id(node)] = new
    return written[id(expression)]


def _decimal(node: Number, numerals: dict[str, str]) -> Expression:
    try:
        text = f"{float(abs(node.value)):.{_DIGITS}g}"
    except OverflowError:
        return node
    mantissa, _, exponent = text.partition("e")
    numerals[text] = rf"{mantissa} \cdot 10^{{{int(exponent)}}}" if exponent else text
    return negate(Symbol(text)) if node.value < 0 else Symbol(text)
