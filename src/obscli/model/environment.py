"""From parameters, functions and ``let`` to a scope: what the names of one stage stand for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from obscli.model.constant import Constants, constants, not_above
from obscli.model.draft import Draft, Entries
from obscli.model.evaluate import evaluate
from obscli.model.expression import Number, Symbol, add, negate, symbols
from obscli.model.fixing import fixed_values
from obscli.model.form import Form, is_zero_form
from obscli.model.meter import Meter
from obscli.model.rules import Rules
from obscli.model.scope import Absent, Scope
from obscli.model.system import Function, Invariant, Parameter
from obscli.model.tensor import Tensor, scalar
from obscli.model.trouble import Incomplete, Problems


@dataclass(frozen=True, slots=True, eq=False)
class Environment:
    """What an expression of this stage may name, and what remains unknown in it."""

    scope: Scope
    parameters: tuple[Parameter, ...]
    functions: tuple[Function, ...]
    invariants: tuple[Invariant, ...]


def environment(
    draft: Draft,
    outer: Entries,
    run: Entries,
    elsewhere: Mapping[str, str],
    meter: Meter,
    problems: Problems,
    *,
    base: bool,
) -> Environment:
    """Evaluate everything but the matrices.

    Parameters
    ----------
    outer : fixes from outside the file (``--fix``); they win over those of the stage
    run : fixes of a run, made after all others
    elsewhere : names that only some stages define, with the names of these stages
    base : whether this is the base of a file with stages, where such names leave the model incomplete
    """
    fixed = fixed_values(draft, outer, run, meter, problems)
    known = constants(draft, fixed, meter, problems)
    values = {**known.values, **_moving(draft, fixed)}
    rules = Rules(draft, fixed)
    scope = Scope(values, rules.derive, meter, _states_absent(draft))
    if base:
        scope = replace(scope, elsewhere=frozenset(elsewhere))
    else:
        lost = {
            name: Absent(f"'{name}' has no value in this stage; only {stages} define it")
            for name, stages in elsewhere.items()
            if draft.let.get(name) is None or draft.let[name].formula is None
        }
        scope = replace(scope, absent={**scope.absent, **lost})
    rules.begin(scope, problems)
    scope = _let(draft, scope, rules, elsewhere, problems)
    rules.end(scope, problems)
    functions = tuple(
        Function(name, one.declared.key.place, rules.known.get(name))
        for one in draft.functions
        for name in one.declared.components
        if name not in fixed
    )
    relations = (*_invariants(draft, scope, problems), *_fixed_rules(draft, fixed, scope, problems))
    return Environment(scope, _free(known, fixed), functions, relations)


def _moving(draft: Draft, fixed: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """Return the values of the time symbol, the functions and their components."""
    time = draft.time or "t"
    values = {time: scalar(Symbol(time))}
    for one in draft.functions:
        parts = {name: fixed.get(name) or scalar(Symbol(name)) for name in one.declared.components}
        values.update(parts)
        values.update({alias: parts[name] for alias, name in one.declared.aliases()})
        whole = one.declared.tensor(lambda name, parts=parts: parts[name].entries[0])  # type: ignore[misc]
        values[one.declared.name] = whole
    return values


def _free(known: Constants, fixed: Mapping[str, Tensor]) -> tuple[Parameter, ...]:
    """Return the parameters left: not fixed, or fixed by an expression of themselves."""
    used: frozenset[str] = frozenset()
    for value in fixed.values():
        used |= symbols(*(entry.constant for entry in value.entries))
    return tuple(one for one in known.free if one.name not in fixed or one.name in used)


def _states_absent(draft: Draft) -> dict[str, Absent]:
    hint = "states stand in `dynamics`, `measurements`, `quantities` and `claims` only"
    groups = {"a state": draft.states, "an input": draft.inputs, "a disturbance": draft.disturbances}
    return {
        name: Absent(f"'{name}' is {what} and has no place here", hint)
        for what, group in groups.items()
        for one in group
        for name in (one.name, *one.components)
    }


def _let(draft: Draft, scope: Scope, rules: Rules, elsewhere: Mapping[str, str], problems: Problems) -> Scope:
    """Evaluate the entries in order, each in the scope of those above it."""
    values, absent = dict(scope.values), dict(scope.absent)
    for name, entry in draft.let.items():
        absent.setdefault(name, not_above(name, entry.key))
    silent, missing = set(scope.silent), set(scope.elsewhere)
    for name, entry in draft.let.items():
        if entry.formula is None:
            if name not in elsewhere:
                problems.add(entry.key.problem(f"let.{name}", "an expression is missing here"))
                silent.add(name)
            continue
        here = replace(
            scope, values=values, absent=absent, silent=frozenset(silent), elsewhere=frozenset(missing)
        )
        try:
            value = evaluate(entry.formula, here, problems)
        except Incomplete:
            missing.add(name)
            continue
        if value is None:
            silent.add(name)
        else:
            values[name] = value
            rules.learn(name, here, problems)
    return replace(
        scope, values=values, absent=absent, silent=frozenset(silent), elsewhere=frozenset(missing)
    )


def _invariants(draft: Draft, scope: Scope, problems: Problems) -> list[Invariant]:
    found = []
    for formula in (formula for one in draft.functions for formula in one.invariants):
        value = evaluate(formula, scope, problems)
        entries: tuple[Form, ...] = value.entries if value else ()
        found += [Invariant(e.constant, formula.place) for e in entries if not is_zero_form(e)]
    return found


def _fixed_rules(
    draft: Draft, fixed: Mapping[str, Tensor], scope: Scope, problems: Problems
) -> Iterator[Invariant]:
    """Yield value' - rule = 0 for functions with a rule that are fixed: their value has to satisfy it."""
    for one in draft.functions:
        if one.derivative is None or not any(name in fixed for name in one.declared.components):
            continue
        rule = evaluate(one.derivative, scope, problems)
        if rule is None or rule.shape != one.declared.shape:
            continue
        for name, form in zip(one.declared.cells, rule.entries, strict=True):
            if name is None or name not in fixed:
                continue
            value = fixed[name].entries[0].constant
            rest = add(scope.derive(value), negate(form.constant))
            if isinstance(rest, Number) and rest.value:
                message = f"the value fixed for '{name}' does not satisfy the derivative given here"
                problems.add(one.derivative.problem(message))
            elif not isinstance(rest, Number):
                yield Invariant(rest, one.derivative.place)
