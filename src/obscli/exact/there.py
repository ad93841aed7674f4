"""Constants of a field at the file's values, as balls."""

from __future__ import annotations

from typing import TYPE_CHECKING

from obscli.exact.ball import BallPoint, OutsideDomainError
from obscli.model.specialise import at_nominal


if TYPE_CHECKING:
    from collections.abc import Iterable

    from flint import arb

    from obscli.exact.field import Element
    from obscli.exact.interpreter import Interpreter


def balls_there(interpreter: Interpreter, elements: Iterable[Element]) -> list[arb] | None:
    """Return constants at the file's values; None where a value is missing or one does not exist.

    Use inside ``precision``.
    """
    nominal = at_nominal(interpreter.system)
    expressions = [nominal.expression(interpreter.element_expression(element)) for element in elements]
    try:
        point = BallPoint(nominal.system(), {}, 1)
        return [point.value(expression)[0] for expression in expressions]
    except (OutsideDomainError, KeyError):
        return None
