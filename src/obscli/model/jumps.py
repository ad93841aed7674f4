"""Segments as systems on one axis of time, and the jumps between them as matrices.

At the end t_j of segment j the state may jump: x⁺ = J x. The right-hand sides are linear in the states before
it; a state without one goes through as it is. They are read in the names of the segment that ends, the time
being t_j; a name of the segment that begins has ``_next`` behind it: ``R_nb_next``. Durations and jumps are
expressions in the parameters of the first segment: where another one has another value, it is the value.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Final, TypeAlias

from obscli.model.constant import unmoving
from obscli.model.covector import scope_of
from obscli.model.draft import Entries
from obscli.model.evaluate import evaluate
from obscli.model.expression import (
    ONE,
    ZERO,
    Derivative,
    Expression,
    add,
    is_zero,
    postorder,
    symbols,
)
from obscli.model.form import Form
from obscli.model.matrices import linear_rows
from obscli.model.meter import Meter
from obscli.model.notation import to_text
from obscli.model.runs import Elaborated
from obscli.model.scope import Scope
from obscli.model.segments import SegmentDraft, SegmentsDraft
from obscli.model.sign import sign_at_nominal
from obscli.model.specialise import Specialisation
from obscli.model.system import Matrix, Parameter, Run, Segment, Segments, System
from obscli.model.tensor import Tensor, named
from obscli.model.trouble import Problems, nearest, shown


#: What stands behind a name of the segment that begins.
NEXT: Final = "_next"


#: Leaves out outputs and states of a system.
Narrowed: TypeAlias = Callable[[System], System]


def segments_of(
    draft: SegmentsDraft | None, elaborated: Elaborated, narrowed: Narrowed, problems: Problems
) -> Segments | None:
    """Return the segments of a file; None where there are none, or one is wrong (which is reported).

    Parameters
    ----------
    elaborated : makes the whole system of a segment; jumps are read in its names
    narrowed : leaves out what is left out of all systems
    """
    if draft is None:
        return None
    systems = [elaborated(one.run, problems) for one in draft.parts]
    whole = [one for one in systems if one is not None]
    if not whole or len(whole) < len(systems):
        return None
    given = whole[0].interval
    start = (given.start if given else None) or ZERO
    parts, stop, seen = [], start, {id(one): narrowed(one) for one in whole}
    for k, (one, system) in enumerate(zip(draft.parts, whole, strict=True)):
        duration = _duration(one, system, problems)
        if duration is None:
            continue
        duration = _in_parameters_of(whole[0], system).expression(duration)
        stop = add(stop, duration)
        following = whole[k + 1] if k + 1 < len(whole) else None
        jump = None
        if one.jump is not None:
            found = _jump(one, system, following, problems)
            jump = found and _kept(_at(found, system, whole[0], stop), system, seen[id(system)])
        run = Run(one.run.name, seen[id(system)], one.run.stage, one.run.node.place, fixed=tuple(one.run.fix))
        parts.append(Segment(run, duration, stop, jump))
    return Segments(start, tuple(parts), draft.node.place)


def _duration(one: SegmentDraft, system: System, problems: Problems) -> Expression | None:
    value = unmoving(one.duration, scope_of(system), problems)
    if value is None:
        return None
    if sign_at_nominal(value, system) in {0, -1}:
        hint = "a motion that takes no time is a `jump` of the segment before it"
        given = f"; {to_text(value)} is not, at these values" if symbols(value) else ""
        problems.add(one.duration.problem(f"a positive duration is expected here{given}", hint))
        return None
    return value


def _jump(one: SegmentDraft, system: System, following: System | None, problems: Problems) -> Matrix | None:
    """Return J at the end of a segment, in the time symbol."""
    path = f"{one.run.path}.jump"
    if following is None:
        hint = "leave it out, or add the segment that begins after the jump"
        problems.add(one.run.node.problem(path, "nothing follows the last segment's jump", hint))
        return None
    rows = _rows(one.jump or {}, system, _both(system, following), path, problems)
    place = {name: j for j, name in enumerate(system.state_names)}
    entries = {
        (i, place[state]): entry
        for i, name in enumerate(system.state_names)
        for state, entry in rows.get(name, {name: ONE}).items()
    }
    _refuse_functions(one, system, entries.values(), path, problems)
    return Matrix(system.n, system.n, entries)


def _kept(jump: Matrix, system: System, narrow: System) -> Matrix:
    """Return the rows and columns of J of the states that are not left out."""
    place = {name: k for k, name in enumerate(narrow.state_names)}
    at = {j: place[name] for j, name in enumerate(system.state_names) if name in place}
    entries = {(at[i], at[j]): one for (i, j), one in jump.entries.items() if i in at and j in at}
    return Matrix(narrow.n, narrow.n, entries)


def _at(jump: Matrix, system: System, first: System, stop: Expression) -> Matrix:
    """Return J at an instant, in the parameters of the first segment."""
    here = _in_parameters_of(first, system, {system.time: stop})
    entries = {place: here.expression(entry) for place, entry in jump.entries.items()}
    return Matrix(jump.rows, jump.columns, {at: one for at, one in entries.items() if not is_zero(one)})


def _in_parameters_of(
    first: System, system: System, further: Mapping[str, Expression] = MappingProxyType({})
) -> Specialisation:
    """Return what replaces parameters by values, where the first system does not have them, or not so."""
    known = {one.name: _value(one) for one in first.parameters}
    changed = {
        one.name: one.nominal
        for one in system.parameters
        if one.nominal is not None and known.get(one.name) != _value(one)
    }
    return Specialisation(system, {**changed, **further})


def _value(parameter: Parameter) -> str:
    return "" if parameter.nominal is None else to_text(parameter.nominal)


def _both(system: System, following: System) -> Scope:
    """Return the names of a segment, and those of the next one with ``_next`` behind them.

    A parameter whose value the next one changes stands in its names as that value.
    """
    own, after = scope_of(system), scope_of(following)
    special = _in_parameters_of(system, following)

    def there(value: Tensor) -> Tensor:
        return Tensor(value.shape, tuple(Form(special.expression(one.constant)) for one in value.entries))

    new = {
        f"{name}{NEXT}": there(value)
        for name, value in after.values.items()
        if f"{name}{NEXT}" not in own.values and not any(one.linear for one in value.entries)
    }
    return replace(own, values={**new, **own.values}, meter=Meter())


def _rows(
    jump: Entries, system: System, scope: Scope, path: str, problems: Problems
) -> dict[str, Mapping[str, Expression]]:
    """Return the rows of J that are given, by state."""
    known = set(system.state_names)
    found: dict[str, Mapping[str, Expression]] = {}
    for name, entry in jump.items():
        target = scope.values.get(name)
        cells = _cells(target, known)
        if target is None or not any(cells):
            spellings = [*(one.vector for one in system.states if one.vector), *system.state_names]
            message = f"'{shown(name)}' is no state{nearest(name, spellings)}"
            problems.add(entry.key.problem(path, message))
            continue
        assert entry.formula is not None
        value = evaluate(entry.formula, scope, problems)
        if value is None:
            continue
        if value.shape != target.shape and not (value.is_scalar and len(cells) == 1):
            message = f"'{name}' is {named(target.shape)}; what it jumps to is {named(value.shape)}"
            problems.add(entry.formula.problem(message))
            continue
        for row in linear_rows(entry.formula, cells, value, problems, local=False):
            if row.name in found:
                problems.add(entry.key.problem(path, f"what '{row.name}' jumps to is given twice"))
            found[row.name] = row.form.linear
    return found


def _cells(target: Tensor | None, known: set[str]) -> tuple[str | None, ...]:
    """Return the state that each entry of a name is; None where it is none."""
    if target is None:
        return ()
    names = (tuple(form.linear) for form in target.entries)
    return tuple(own[0] if len(own) == 1 and own[0] in known else None for own in names)


def _refuse_functions(
    one: SegmentDraft, system: System, entries: Iterable[Expression], path: str, problems: Problems
) -> None:
    """Report functions left open: nobody knows their value at the instant of the jump."""
    names = {function.name for function in system.functions}
    entries = tuple(entries)
    used = symbols(*entries) & names
    used |= {node.name for node in postorder(*entries) if isinstance(node, Derivative)}
    if used:
        message = f"the value of {', '.join(sorted(used))} at the instant of the jump is not known"
        hint = "give it with `fix`, or as an expression of time under `let`"
        problems.add(one.run.node.problem(path, message, hint))
