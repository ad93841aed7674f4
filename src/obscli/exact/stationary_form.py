"""The stationary system that stands for a system: itself, where it is one, else the smallest found."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from obscli.exact.finding import Undecided
from obscli.exact.lift_finding import Lift, NotReducible
from obscli.exact.stationary import find_stationary
from obscli.model.expression import ONE, symbols


if TYPE_CHECKING:
    from collections.abc import Sequence

    from obscli.exact.lift_finding import Obstacle, Rows
    from obscli.model.expression import Expression
    from obscli.model.system import Matrix, System

#: So many entries that stand in the way are named.
_SHOWN: Final = 2


def lift_of(system: System) -> Lift | str:
    """Return a stationary system with the outputs of a system, or why there is none."""
    if system.discrete:
        return "stationary systems are those of systems in continuous time"
    if _is_stationary(system):
        return itself(system)
    found = find_stationary(system)
    if isinstance(found, Undecided):
        return f"whether it is reducible is undecided: {found.reason}"
    if isinstance(found, NotReducible):
        return f"not reducible: {_words(found.obstacles)}"
    lift = found.smallest
    entries = [entry for form in lift.variables for entry in form.values()]
    entries += [entry for row in (*lift.A, *lift.H) for entry in row.values()]
    unknown = sorted(symbols(*entries) & {function.name for function in system.functions})
    if unknown:
        return f"its stationary system depends on {', '.join(unknown)}, of which the file gives no value"
    return lift


def itself(system: System) -> Lift:
    """Return a stationary system as its own lift: z = x."""
    variables = tuple({name: ONE} for name in system.state_names)
    return Lift(system.state_names, variables, _rows(system.A), _rows(system.H))


def _is_stationary(system: System) -> bool:
    moving = {system.time, *(function.name for function in system.functions)}
    return not moving & symbols(*system.A.entries.values(), *system.H.entries.values())


def _rows(matrix: Matrix) -> Rows:
    rows: list[dict[int, Expression]] = [{} for _ in range(matrix.rows)]
    for (i, j), entry in matrix.entries.items():
        rows[i][j] = entry
    return tuple(rows)


def _words(obstacles: Sequence[Obstacle]) -> str:
    shown = [
        f"{one.entry}{f' ({one.place})' if one.place else ''}: {one.reason}" for one in obstacles[:_SHOWN]
    ]
    more = len(obstacles) - len(shown)
    return "; ".join([*shown, f"and {more} more"] if more else shown)
