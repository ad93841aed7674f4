"""Exact substitutions: ``fix`` of a stage or run, and ``--fix``; right-hand sides refer to values outside."""

from __future__ import annotations

from collections.abc import Mapping

from obscli.model.constant import constants
from obscli.model.declaration import Declared
from obscli.model.draft import Draft, Entries, Entry
from obscli.model.evaluate import evaluate
from obscli.model.expression import Symbol, TimeDerivative
from obscli.model.form import Form, is_zero_form
from obscli.model.meter import Meter
from obscli.model.rules import MOST_DERIVED
from obscli.model.scope import Scope
from obscli.model.tensor import Tensor, named, scalar
from obscli.model.trouble import Problems, nearest, shown


def fixed_values(
    draft: Draft, outer: Entries, run: Entries, meter: Meter, problems: Problems
) -> dict[str, Tensor]:
    """Return the value of every fixed scalar name; ``outer`` wins over the stage's own.

    Parameters
    ----------
    run : fixes of a run, made last: they refer to the values that hold outside the run
    """
    outside = _layer(draft, outer, {}, meter, problems)
    inside = _layer(draft, draft.fix, outside, meter, problems)
    known = {**inside, **outside}
    return {**known, **_layer(draft, run, known, meter, problems)}


def _layer(
    draft: Draft, fix: Entries, known: Mapping[str, Tensor], meter: Meter, problems: Problems
) -> dict[str, Tensor]:
    if not fix:
        return {}
    scope = _scope(draft, known, meter, problems)
    result: dict[str, Tensor] = {}
    for name, entry in fix.items():
        result.update(_fixed(name, entry, draft, scope, problems))
    return result


def _scope(draft: Draft, known: Mapping[str, Tensor], meter: Meter, problems: Problems) -> Scope:
    """Return the scope of right-hand sides: parameters, functions and time."""
    time = draft.time or "t"
    values = {**constants(draft, known, meter, problems).values, time: scalar(Symbol(time))}
    names: set[str] = set()
    for one in draft.functions:
        names.update(one.declared.components)
        values[one.declared.name] = one.declared.tensor(lambda name: _symbol(name, known))
        values.update({name: Tensor((), (_symbol(name, known),)) for name in one.declared.components})
    return Scope(values, TimeDerivative(time, {}, frozenset(names), MOST_DERIVED), meter)


def _symbol(name: str, known: Mapping[str, Tensor]) -> Form:
    return known[name].entries[0] if name in known else Form(Symbol(name))


def _fixed(name: str, entry: Entry, draft: Draft, scope: Scope, problems: Problems) -> dict[str, Tensor]:
    path = "fix" if entry.formula is None else entry.formula.path
    functions = {one.declared.name: one.declared for one in draft.functions}
    components = {part for one in functions.values() for part in one.components}
    if name not in draft.parameters and name not in functions and name not in components:
        known = [*draft.parameters, *functions, *components]
        message = f"'{shown(name)}' is no parameter or function{nearest(name, known)}"
        hint = "states are left out with --without" if _is_state(name, draft) else ""
        problems.add(entry.key.problem(path, message, hint))
        return {}
    if entry.formula is None:
        problems.add(entry.key.problem(path, "an expression is missing here"))
        return {}
    value = evaluate(entry.formula, scope, problems)
    if value is None:
        return {}
    if name in functions and functions[name].shape:
        return spread(functions[name], entry, value, problems)
    if not value.is_scalar:
        problems.add(entry.formula.problem(f"'{name}' is a scalar; the value is {named(value.shape)}"))
        return {}
    return {name: scalar(value.entries[0])}


def spread(one: Declared, entry: Entry, value: Tensor, problems: Problems) -> dict[str, Tensor]:
    """Return the value of each component of a vector function; 0 stands for a vector of zeros."""
    if value.is_scalar and is_zero_form(value.entries[0]):
        return {name: scalar(value.entries[0]) for name in one.components}
    if value.shape != one.shape:
        message = f"'{one.name}' is {named(one.shape)}; the value is {named(value.shape)}"
        assert entry.formula is not None
        problems.add(entry.formula.problem(message))
        return {}
    pairs = zip(one.cells, value.entries, strict=True)
    return {cell: scalar(form) for cell, form in pairs if cell is not None}


def _is_state(name: str, draft: Draft) -> bool:
    return any(name in {one.name, *one.components} for one in draft.states)
