"""New variables of a system as states: names that a person can read, and what carries over of the old ones.

A variable that is a single state keeps its name and everything said of it; any other is called after the
first state in it: ``z_psi2`` for g*psi2 - b_a1.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final

from obscli.model.catalogue import RESERVED
from obscli.model.expression import Number, is_one, number
from obscli.model.notation import covector_text
from obscli.model.system import Covector, State, System
from obscli.model.tokens import LONGEST_NAME


#: Whole numbers above this make an integer form hard to read.
_MANY_DIGITS: Final = 10**9


def is_state(form: Covector) -> bool:
    """Whether a linear form is one state by itself."""
    return len(form) == 1 and all(is_one(entry) for entry in form.values())


def with_plain_lead(form: Covector) -> Covector:
    """Return a linear form; of many-digit numbers, with 1 in front of its first state."""
    numbers = [entry.value for entry in form.values() if isinstance(entry, Number)]
    longest = max((max(abs(n.numerator), n.denominator) for n in numbers), default=0)
    if len(numbers) < len(form) or longest <= _MANY_DIGITS:
        return form
    return {state: number(value / numbers[0]) for state, value in zip(form, numbers, strict=True)}


def variable_states(system: System, forms: Sequence[Covector]) -> tuple[State, ...]:
    """Return the states that stand for linear forms in the states of a system.

    Parameters
    ----------
    forms : independent linear forms, states in order
    """
    names = variable_names(system, forms)
    return tuple(_state(system, form, name) for form, name in zip(forms, names, strict=True))


def variable_names(system: System, forms: Sequence[Covector]) -> tuple[str, ...]:
    """Return a name for each linear form, different from each other and from all names of the system."""
    taken = taken_names(system)
    found = []
    for form in forms:
        if is_state(form):
            found.append(next(iter(form)))
            continue
        name = next(one for one in _candidates(next(iter(form))) if one not in taken)
        taken.add(name)
        found.append(name)
    return tuple(found)


def free_name(system: System, wanted: str, others: Sequence[str] = ()) -> str:
    """Return a name, numbered where the system or others have it."""
    taken = taken_names(system) | set(others)
    return next(one for one in _numbered(wanted) if one not in taken)


def taken_names(system: System) -> set[str]:
    """Return every name of a system, and those that no file may use."""
    names = {system.time, *RESERVED, *system.inputs, *system.disturbances}
    for state in system.states:
        names |= {state.name, state.vector}
    for output in system.outputs:
        names |= {output.name, output.vector}
    names |= {parameter.name for parameter in system.parameters}
    names |= {function.name for function in system.functions}
    return names | {quantity.name for quantity in system.quantities}


def _candidates(state: str) -> Iterator[str]:
    yield from _numbered(f"z_{state}" if len(state) < LONGEST_NAME - 8 else "z")


def _numbered(name: str) -> Iterator[str]:
    yield name
    for k in range(2, 100_000):
        yield f"{name}_{k}"


def _state(system: System, form: Covector, name: str) -> State:
    first = next(one for one in system.states if one.name in form)
    if is_state(form):
        return replace(first, vector="")
    return State(
        name,
        first.place,
        unit=_unit(system, form),
        description=covector_text(form, system.state_names),
        latex=f"z_{{{first.latex}}}" if first.latex else "",
    )


def _unit(system: System, form: Covector) -> str:
    """Return the unit of the states in a form where all have the same, and only numbers stand before them."""
    units = {state.unit for state in system.states if state.name in form}
    return units.pop() if len(units) == 1 and all(isinstance(e, Number) for e in form.values()) else ""
