"""The initial standard deviations in ``noise``: ``P0_std``, or the roots of the diagonal of ``P0``."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from obscli.model.evaluate import evaluate
from obscli.model.expression import Expression, power
from obscli.model.formula import formula
from obscli.model.scope import Scope
from obscli.model.system import State
from obscli.model.tensor import Tensor
from obscli.model.tree import Mapping, Node
from obscli.model.trouble import Problems


def prior_deviations(node: Node | None, states: tuple[State, ...], scope: Scope) -> dict[str, Expression]:
    """Return the standard deviation by state, for the states it is given for.

    Parameters
    ----------
    node : ``noise``, checked before: what is wrong in it is reported there and left out here
    """
    if not isinstance(node, Mapping):
        return {}
    found: dict[str, Expression] = {}
    for key, exponent in (("P0_std", Fraction(1)), ("P0", Fraction(1, 2))):
        value = node.get(key)
        pairs = () if value is None else _diagonal(value, states, scope)
        found |= {name: power(entry, exponent) for name, entry in pairs}
    return found


def _diagonal(node: Node, states: tuple[State, ...], scope: Scope) -> Iterator[tuple[str, Expression]]:
    """Yield the diagonal entries by state: a value for all, a list, a matrix, or a mapping by name."""
    if not isinstance(node, Mapping):
        yield from _spread(node, tuple(state.name for state in states), scope)
        return
    for key, value in node.entries:
        names = tuple(state.name for state in states if key.text in (state.name, state.vector))
        yield from _spread(value, names, scope)


def _spread(node: Node, names: tuple[str, ...], scope: Scope) -> Iterator[tuple[str, Expression]]:
    value = evaluate(formula(node, "noise", Problems()), scope, Problems())
    if value is not None:
        yield from zip(names, _entries(value, len(names)), strict=False)


def _entries(value: Tensor, size: int) -> list[Expression]:
    forms = value.entries
    if value.is_scalar:
        return [forms[0].constant] * size
    step = size + 1 if len(value.shape) == 2 and value.shape == (size, size) else 1
    return [form.constant for form in forms[::step]]
