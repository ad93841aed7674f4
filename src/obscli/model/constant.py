"""Parameters: free symbols with nominal values, derived ones, and those that are fixed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import cast

from obscli.model.draft import Draft, ParameterDraft
from obscli.model.evaluate import evaluate
from obscli.model.expression import Expression, ExpressionTooLarge, Symbol, is_zero
from obscli.model.formula import Formula
from obscli.model.meter import Meter
from obscli.model.notation import to_text
from obscli.model.scope import Absent, Scope
from obscli.model.sign import sign
from obscli.model.system import Assumption, Parameter
from obscli.model.tensor import Tensor, named, scalar
from obscli.model.tree import Scalar
from obscli.model.trouble import Problems


@dataclass(frozen=True, slots=True, eq=False)
class Constants:
    """The values of all parameters, and those that are free."""

    values: Mapping[str, Tensor]
    free: tuple[Parameter, ...]


def unchanging(node: Expression) -> Expression:
    """Stand for d/dt where nothing depends on time; ``deriv`` of a constant is refused by its names."""
    return node


def constants(draft: Draft, fixed: Mapping[str, Tensor], meter: Meter, problems: Problems) -> Constants:
    """Evaluate the parameters in order; each may use those above it."""
    values: dict[str, Tensor] = {}
    free: list[Parameter] = []
    scope = Scope(values, unchanging, meter, _absent(draft))
    for name, parameter in draft.parameters.items():
        nominal, derived = _value(parameter, draft, scope, problems)
        if name in fixed:
            values[name] = fixed[name]
        elif derived and nominal is not None:
            values[name] = scalar(nominal)
            continue
        else:
            values[name] = scalar(Symbol(name))
        _check_sign(parameter, nominal, problems)
        assume = cast("Assumption", parameter.assume or "real")
        place = parameter.key.place
        free.append(Parameter(name, place, nominal, assume, parameter.unit, parameter.description))
    return Constants(values, tuple(free))


def _value(
    parameter: ParameterDraft, draft: Draft, scope: Scope, problems: Problems
) -> tuple[Expression | None, bool]:
    """Return the value and whether it names other parameters."""
    if parameter.value is None:
        return None, False
    derived = any(name in draft.parameters for name in parameter.value.names)
    return constant(parameter.value, scope, problems), derived


def constant(formula: Formula, scope: Scope, problems: Problems) -> Expression | None:
    """Evaluate a scalar free of states; None where it is reported."""
    value = evaluate(formula, scope, problems)
    if value is None:
        return None
    if not value.is_scalar:
        problems.add(formula.problem(f"a scalar is expected here, not {named(value.shape)}"))
        return None
    if value.entries[0].linear:
        problems.add(formula.problem("states have no place here; a constant is expected"))
        return None
    return value.entries[0].constant


def unmoving(formula: Formula, scope: Scope, problems: Problems) -> Expression | None:
    """Evaluate a scalar free of states, time and functions; None where it is reported."""
    value = constant(formula, scope, problems)
    if value is None:
        return None
    try:
        rate = scope.derive(value)
    except ExpressionTooLarge as error:
        problems.add(formula.problem(str(error)))
        return None
    if is_zero(rate):
        return value
    problems.add(formula.problem("a constant is expected here, and this depends on time"))
    return None


def _absent(draft: Draft) -> dict[str, Absent]:
    """Return why a parameter's value may not use certain names (those above it have values)."""
    text = "a parameter is constant; put an expression of time, functions or `let` under `let`"
    moving = [draft.time or "t", *draft.let]
    moving += [part for one in draft.functions for part in (one.declared.name, *one.declared.components)]
    absent = {other: Absent(f"'{other}' is no parameter", text) for other in moving}
    return absent | {name: not_above(name, one.key) for name, one in draft.parameters.items()}


def not_above(name: str, key: Scalar) -> Absent:
    """Return why a name defined at or below the place of use has no value there."""
    message = f"'{name}' is not defined above this place; its definition is in line {key.line}"
    return Absent(message, "each entry may use those above it only")


def _check_sign(parameter: ParameterDraft, nominal: Expression | None, problems: Problems) -> None:
    refused = {"positive": {0, -1}, "nonzero": {0}}.get(parameter.assume or "", set())
    if parameter.value is not None and nominal is not None and refused and sign(nominal) in refused:
        message = f"the value {to_text(nominal)} contradicts `assume: {parameter.assume}`"
        problems.add(parameter.value.problem(message))
