"""Proof that coefficients are not zero: their ball at some rational point excludes zero.

The field takes its generators as independent. Where they secretly are not (atan(1/2) + atan(1/3) = π/4),
a coefficient that is zero may look different from zero; its balls then all contain zero, and whatever
rests on it is undecided.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from obscli.exact.ball import BallPoint, OutsideDomainError, precision, random_point
from obscli.exact.errors import UndecidedError
from obscli.exact.lower import highest_derivative_of, names_behind, used_names
from obscli.model.expression import Expression, Number
from obscli.model.notation import to_text


if TYPE_CHECKING:
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
    raise UndecidedError(
        f"it could not be decided whether {to_text(open_cases[0])} is zero: "
        "functions in it may depend on each other"
    )


def _not_seen(
    interpreter: Interpreter, expressions: Sequence[Expression], bits: int, seed: int
) -> list[Expression] | None:
    """Return the expressions not seen to differ from zero at one point; None outside the domain."""
    system, definitions = interpreter.system, interpreter.definitions
    length = 1 + highest_derivative_of([*expressions, *definitions.values()])
    names = used_names(system) | names_behind(system, expressions)
    values = random_point(system, names - definitions.keys(), length, seed)
    with precision(bits, length):
        try:
            point = BallPoint(system, values, length, definitions)
            return [e for e in expressions if point.value(e)[0].contains(0)]
        except OutsideDomainError:
            return None
