"""Proof that coefficients are not zero: their ball at some rational point excludes zero.

The field takes its generators as independent. Where they secretly are not (atan(1/2) + atan(1/3) = π/4),
a coefficient that is zero may look different from zero; its balls then all contain zero, and whatever
rests on it is undecided.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from obscli.exact.ball import BallPoint, OutsideDomainError, precision, random_point
from obscli.exact.determinant import determinant
from obscli.exact.echelon import polynomial_row, reduced_echelon
from obscli.exact.errors import UndecidedError
from obscli.exact.lower import highest_derivative_of
from obscli.model.expression import Expression, Number
from obscli.model.notation import to_text


if TYPE_CHECKING:
    from fractions import Fraction

    from obscli.exact.field import Element
    from obscli.exact.interpreter import Interpreter

_BITS = (128, 128, 512, 2000)
_POINTS = 30


def require_nonzero(interpreter: Interpreter, expressions: Sequence[Expression]) -> None:
    """Prove that none of the expressions vanishes identically.

    Raises
    ------
    UndecidedError : the ball of some expression contains zero at every point and precision tried
    """
    open_cases = [e for e in expressions if not (isinstance(e, Number) and e.value)]
    if not open_cases:
        return
    attempts = iter(_BITS)
    bits = next(attempts)
    for seed in range(_POINTS):
        rest = _not_seen(interpreter, open_cases, bits, seed)
        if rest is None:
            continue
        if not rest:
            return
        open_cases, bits = rest, next(attempts, 0)
        if not bits:
            break
    raise UndecidedError(_reason(open_cases[0]))


def first_nonzero(interpreter: Interpreter, elements: Sequence[Element]) -> int | None:
    """Return the index of an element proved to differ from zero, None where all are zero.

    Raises
    ------
    UndecidedError : elements look different from zero, but no ball confirms it of any
    """
    suspects = {k: interpreter.element_expression(e) for k, e in enumerate(elements) if e}
    if not suspects:
        return None
    for seed, bits in zip(range(_POINTS), _every_precision(), strict=False):
        rest = _not_seen(interpreter, list(suspects.values()), bits, seed)
        seen = [k for k, e in suspects.items() if rest is not None and e not in rest]
        if seen:
            return seen[0]
    raise UndecidedError(_reason(next(iter(suspects.values()))))


def require_independent(interpreter: Interpreter, rows: Sequence[Mapping[int, Element]]) -> None:
    """Prove that rows found independent are: a minor of theirs differs from zero at some point.

    Raises
    ------
    UndecidedError : the ball of the minor contains zero at every point and precision tried
    """
    field = interpreter.field
    pivots = reduced_echelon(field, [polynomial_row(field, row) for row in rows], _columns(rows))
    place = {column: k for k, column in enumerate(pivots)}
    entries = [
        {place[j]: interpreter.element_expression(e) for j, e in row.items() if j in place} for row in rows
    ]
    for seed, bits in zip(range(_POINTS), _every_precision(), strict=False):
        if len(place) == len(rows) and _nonsingular(interpreter, entries, bits, seed):
            return
    raise UndecidedError("it could not be decided whether the rows of this basis are independent")


def _columns(rows: Sequence[Mapping[int, Element]]) -> list[int]:
    return sorted({j for row in rows for j in row})


def _nonsingular(
    interpreter: Interpreter, entries: Sequence[Mapping[int, Expression]], bits: int, seed: int
) -> bool:
    """Whether a square matrix is seen to have a determinant other than zero at one point."""
    values, length = _point(interpreter, [e for row in entries for e in row.values()], seed)
    with precision(bits, length):
        try:
            point = BallPoint(interpreter.system, values, length, interpreter.definitions)
            rows = [{j: point.value(e)[0] for j, e in row.items()} for row in entries]
            return not determinant(rows).contains(0)
        except OutsideDomainError:
            return False


def _every_precision() -> Iterator[int]:
    """The precisions to try in turn, the highest for the remaining points."""
    yield from _BITS
    while True:
        yield _BITS[-1]


def _reason(expression: Expression) -> str:
    text = to_text(expression)
    return f"it could not be decided whether {text} is zero: functions in it may depend on each other"


def _not_seen(
    interpreter: Interpreter, expressions: Sequence[Expression], bits: int, seed: int
) -> list[Expression] | None:
    """Return the expressions not seen to differ from zero at one point; None outside the domain."""
    values, length = _point(interpreter, expressions, seed)
    with precision(bits, length):
        try:
            point = BallPoint(interpreter.system, values, length, interpreter.definitions)
            return [e for e in expressions if point.value(e)[0].contains(0)]
        except OutsideDomainError:
            return None


def _point(
    interpreter: Interpreter, expressions: Sequence[Expression], seed: int
) -> tuple[dict[str, Fraction], int]:
    """Return a random point, and how many terms of the series at it the expressions need."""
    definitions = interpreter.definitions
    length = 1 + highest_derivative_of([*expressions, *definitions.values()])
    return random_point(interpreter.system, interpreter.names - definitions.keys(), length, seed), length
