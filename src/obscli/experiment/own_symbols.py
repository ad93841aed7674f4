"""Parameters whose nominal values differ between runs, told apart: each value a symbol of its own.

Generic ranks hold for independent symbols: a rate of 0.1 in one run and of 0.2 in another are two parameters
there, although the file gives them one name.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from obscli.model.expression import Expression, Symbol
from obscli.model.notation import to_text
from obscli.model.specialise import Specialisation
from obscli.model.system import Parameter, Run, System


@dataclass(frozen=True, slots=True)
class OwnSymbol:
    """``name`` stands for parameter ``of`` in the runs where its value is ``value``."""

    name: str
    of: str
    value: str
    runs: tuple[str, ...]


def told_apart(
    runs: Sequence[Run], base: System | None = None
) -> tuple[tuple[Run, ...], tuple[OwnSymbol, ...]]:
    """Return the runs with a symbol for every value of a parameter, and the symbols that are new.

    The value in the file's system (the first run, where that is not given) keeps the parameter's name.
    """
    taken = {name for run in runs for name in _names(run.system)}
    symbols: dict[tuple[str, str], str] = {}
    used: dict[tuple[str, str], list[str]] = {}
    first = {} if base is None else {one.name: _value(one) for one in base.parameters}
    known: dict[int, System] = {}
    result = []
    for run in runs:
        renamed: dict[str, str] = {}
        for parameter in run.system.parameters:
            value = _value(parameter)
            if first.setdefault(parameter.name, value) == value:
                continue
            key = (parameter.name, value)
            if key not in symbols:
                symbols[key] = _new_name(parameter.name, taken)
            used.setdefault(key, []).append(run.name)
            renamed[parameter.name] = symbols[key]
        system = known.setdefault(id(run.system), _renamed(run.system, renamed))
        result.append(replace(run, system=system))
    own = (OwnSymbol(symbols[key], *key, tuple(names)) for key, names in used.items())
    return tuple(result), tuple(own)


def _value(parameter: Parameter) -> str:
    return "" if parameter.nominal is None else to_text(parameter.nominal)


def unused_name(name: str, systems: Iterable[System]) -> str:
    """Return a name like the one given that no system uses."""
    return _new_name(name, {one for system in systems for one in _names(system)})


def _names(system: System) -> tuple[str, ...]:
    parameters, functions = (one.name for one in system.parameters), (one.name for one in system.functions)
    return (system.time, *system.state_names, *parameters, *functions)


def _new_name(name: str, taken: set[str]) -> str:
    k = 2
    while f"{name}_{k}" in taken:
        k += 1
    taken.add(f"{name}_{k}")
    return f"{name}_{k}"


def _renamed(system: System, names: Mapping[str, str]) -> System:
    if not names:
        return system
    values: dict[str, Expression] = {old: Symbol(new) for old, new in names.items()}
    special = Specialisation(system, values).system()
    own: list[Parameter] = [replace(one, name=names.get(one.name, one.name)) for one in system.parameters]
    return replace(special, parameters=tuple(own))
