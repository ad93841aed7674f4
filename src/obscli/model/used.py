"""A system without the parameters and functions that nothing in it depends on."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from obscli.model.expression import Expression, symbols
from obscli.model.system import System


def without_unused(system: System) -> System:
    """Return the system with the parameters, functions and relations that its other parts depend on."""
    names = _used(system)
    return replace(
        system,
        parameters=tuple(one for one in system.parameters if one.name in names),
        functions=tuple(one for one in system.functions if one.name in names),
        invariants=tuple(one for one in system.invariants if symbols(one.expression) & names),
    )


def _used(system: System) -> frozenset[str]:
    """Return the names in a system, and in the rules and relations of the functions among them."""
    names = symbols(*_expressions(system))
    while True:
        rules = [f.derivative for f in system.functions if f.derivative is not None and f.name in names]
        relations = [i.expression for i in system.invariants if symbols(i.expression) & names - {system.time}]
        more = names | symbols(*rules, *relations)
        if more == names:
            return names
        names = more


def _expressions(system: System) -> Iterator[Expression]:
    noise, interval = system.noise, system.interval
    matrices = [system.A, system.H, system.B, system.G, *((noise.Q, noise.R, noise.P0) if noise else ())]
    for matrix in matrices:
        if matrix is not None:
            yield from matrix.entries.values()
    for quantity in system.quantities:
        yield from quantity.coefficients.values()
    single = [
        system.step,
        noise.step if noise else None,
        *((interval.start, interval.stop) if interval else ()),
    ]
    for output in system.outputs:
        single += [output.every, *(end for span in output.during or () for end in span)]
    yield from (one for one in (*single, *(state.scale for state in system.states)) if one is not None)
