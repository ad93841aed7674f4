"""Formulas to tensors: a stack machine over the postfix form."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import groupby
from typing import Final, TypeAlias

from obscli.model.block import block
from obscli.model.catalogue import CATALOGUE, NOT_ANALYTIC, RESERVED
from obscli.model.expression import Expression, ExpressionTooLarge, Number, Pi
from obscli.model.form import Form, Impossible
from obscli.model.formula import Formula, Located
from obscli.model.scope import Absent, Scope
from obscli.model.tensor import (
    Tensor,
    index,
    matmul,
    minus,
    over,
    plus,
    scalar,
    stack,
    times,
    to_the,
    transpose,
)
from obscli.model.tree import Scalar
from obscli.model.trouble import Incomplete, Problems, Silence, Trouble, nearest, shown


@dataclass(frozen=True, slots=True, eq=False)
class Listing:
    """A list not yet stacked: ``block`` takes its parts as they are."""

    parts: tuple[Value, ...]


Value: TypeAlias = Tensor | Listing

_PI: Final = scalar(Pi())
_BINARY: Final[dict[str, Callable[[Tensor, Tensor], Tensor]]] = {
    "+": plus,
    "-": lambda left, right: plus(left, right, "-"),
    "*": times,
    "/": over,
    "@": matmul,
    "^": to_the,
}


def evaluate(formula: Formula, scope: Scope, problems: Problems) -> Tensor | None:
    """Return the value, or None where something is wrong (and now reported).

    Raises
    ------
    Incomplete
        where a name has a value only in some stages
    """
    bad = _unknown_names(formula, scope, problems)
    try:
        scope.meter.charge(2)
        value = _run(formula, bad, scope, problems)
        if value is not None:
            scope.meter.weigh(value.entries)
    except Incomplete:
        raise
    except Silence:
        return None
    except Impossible as error:
        problems.add(formula.problem(error.message, error.hint))
        return None
    return value


def _unknown_names(formula: Formula, scope: Scope, problems: Problems) -> set[int]:
    """Report every name of the formula that has no value here; return the texts with such names."""
    bad: set[int] = set()
    for located in formula.steps:
        name = located.step.text
        if located.step.operation == "call":
            absent = _uncallable(name, scope)
        elif located.step.operation == "name" and name != "pi":
            found = _lookup(name, scope)
            absent = found if isinstance(found, Absent) else None
            if found is None:
                bad.add(id(located.node))
        else:
            continue
        if absent is not None:
            problems.add(formula.problem(absent.message, absent.hint, located))
            bad.add(id(located.node))
    return bad


def _lookup(name: str, scope: Scope) -> Tensor | Absent | None:
    """Return what the scope knows; None where it is already reported."""
    try:
        return scope.find(name)
    except Silence as silence:
        if type(silence) is not Silence:
            raise
    return None


def _uncallable(name: str, scope: Scope) -> Absent | None:
    """Return why the name cannot be called, None where it can."""
    if name in CATALOGUE or name in {"block", "deriv"}:
        return None
    if name in scope.values or name == "pi":
        hint = f"a product is written {name}*(…), a function of time without its argument: {name}"
        return Absent(f"'{name}' is not a function to be called", hint)
    if name.lower() in NOT_ANALYTIC:
        return Absent(f"'{name}' is not analytic and refused", NOT_ANALYTIC[name.lower()])
    return Absent(f"unknown function '{shown(name)}'{nearest(name, RESERVED - {'pi'})}")


def _run(formula: Formula, bad: set[int], scope: Scope, problems: Problems) -> Tensor | None:
    """Evaluate text by text, so that the troubles of all entries of a list are reported."""
    values: list[Value] = []
    sound = formula.sound and not bad
    for _, group in groupby(formula.steps, key=lambda located: id(located.node)):
        steps = tuple(group)
        is_text = isinstance(steps[0].node, Scalar)
        if id(steps[0].node) in bad or not (sound or is_text):
            continue
        try:
            _steps(formula, steps, values, scope)
        except Trouble as trouble:
            problems.add(trouble.problem)
            sound = False
    return settled(values[0]) if sound else None


def _steps(formula: Formula, steps: tuple[Located, ...], values: list[Value], scope: Scope) -> None:
    """Run the steps on the stack of values."""
    for located in steps:
        start = len(values) - located.step.arity
        arguments = tuple(values[start:])
        del values[start:]
        try:
            value = _apply(located, arguments, scope)
            if located.step.operation not in {"number", "list"}:
                scope.meter.charge(1 if isinstance(value, Listing) else value.weight)
        except (Impossible, ExpressionTooLarge) as error:
            hint = getattr(error, "hint", "")
            raise formula.trouble(getattr(error, "message", str(error)), hint, located) from None
        values.append(value)


def _apply(located: Located, arguments: tuple[Value, ...], scope: Scope) -> Value:
    """Return the value of one step."""
    step = located.step
    match step.operation:
        case "number":
            assert step.value is not None
            return scalar(Number(step.value))
        case "name":
            return _named(step.text, scope)
        case "list":
            return Listing(arguments)
        case "call" if step.text == "block":
            return _block(arguments)
    operands = tuple(settled(argument) for argument in arguments)
    match step.operation:
        case "negate":
            return minus(operands[0])
        case "transpose":
            return transpose(operands[0])
        case "index":
            return index(operands[0], tuple(_position(operand) for operand in operands[1:]))
        case "call":
            return _call(step.text, operands, scope)
        case "@":
            scope.meter.charge(_matmul_work(operands[0], operands[1]))
    return _BINARY[step.operation](*operands)


def _named(name: str, scope: Scope) -> Tensor:
    if name == "pi":
        return _PI
    found = scope.find(name)
    assert isinstance(found, Tensor)
    return found


def settled(value: Value) -> Tensor:
    """Return the value as a tensor; lists are stacked."""
    if isinstance(value, Tensor):
        return value
    return stack(tuple(settled(part) for part in value.parts))


def _block(arguments: tuple[Value, ...]) -> Tensor:
    usage = "it is written block([[A, B], [C, D]])"
    if len(arguments) != 1 or not isinstance(arguments[0], Listing):
        raise Impossible(f"block takes one list of rows; {usage}")
    rows = arguments[0].parts
    if not all(isinstance(row, Listing) for row in rows):
        raise Impossible(f"every row of block is a list; {usage}")
    return block(
        tuple(tuple(settled(part) for part in row.parts) for row in rows if isinstance(row, Listing))
    )


def _position(value: Tensor) -> int:
    form = value.entries[0]
    constant = form.constant
    if (
        not value.is_scalar
        or form.linear
        or not isinstance(constant, Number)
        or constant.value.denominator != 1
    ):
        raise Impossible("an index is a whole number, from 1")
    return int(constant.value)


def _call(name: str, operands: tuple[Tensor, ...], scope: Scope) -> Tensor:
    if name != "deriv":
        return CATALOGUE[name](operands)
    if len(operands) != 1:
        raise Impossible("deriv takes one argument: deriv(f)")
    (value,) = operands
    parts = (scope.derive(_without_states(entry)) for entry in value.entries)
    return Tensor(value.shape, tuple(scalar(part).entries[0] for part in parts))


def _without_states(form: Form) -> Expression:
    if form.linear:
        name = next(iter(form.linear))
        hint = "the derivative of a state is its right-hand side; write that"
        raise Impossible(f"'{name}' stands inside deriv, which takes functions of time", hint)
    return form.constant


def _matmul_work(left: Tensor, right: Tensor) -> int:
    columns = right.shape[1] if len(right.shape) == 2 else 1
    return len(left.entries) * columns // 4
