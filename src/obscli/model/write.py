"""A system as the text of a model file: deterministic, made to be read by people, and read back as it was.

Matrices by the names of rows and columns, expressions in the grammar of the file, vectors taken apart into
their components. Claims and experiments are about the file that a system comes from and are not written.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from obscli.model.expression import Expression, symbols
from obscli.model.notation import covector_text
from obscli.model.system import Function, Matrix, Output, Parameter, Quantity, State, System
from obscli.model.write_noise import noise_lines
from obscli.model.write_signals import signal_lines
from obscli.model.write_text import (
    Entry,
    Items,
    Value,
    block_lines,
    entry_lines,
    formula,
    list_lines,
    prose_lines,
    scalar,
    with_decimals,
)


#: Longer symbols are refused where a model is read.
_LONGEST_LATEX: Final = 80


@dataclass(frozen=True, slots=True)
class Heading:
    """What stands above a system: identification, and comments, one a line.

    ``rank``: pinned under ``expect``, where it is known.
    """

    name: str = ""
    title: str = ""
    description: str = ""
    source: str = ""
    comments: tuple[str, ...] = ()
    rank: int | None = None


def write_model(system: System, heading: Heading = Heading()) -> str:
    """Return the text of a model file with this system for its only one.

    Parameters
    ----------
    system : the stage to write, everything in it replaced already
    heading : identification and comments
    """
    sections = (
        _heading(heading),
        _names(system),
        _states(system),
        _matrices(system),
        noise_lines(system),
        _interval(system),
        _quantities(system),
        _expect(heading),
    )
    return "\n".join(line for section in sections for line in section) + "\n"


def _heading(heading: Heading) -> Iterator[str]:
    for comment in heading.comments:
        yield from (f"# {line}".rstrip() for line in comment.splitlines())
    given = {
        "name": heading.name,
        "title": heading.title,
        "description": heading.description,
        "source": heading.source,
    }
    for key, text in given.items():
        if text:
            yield from prose_lines(key, text)


def _names(system: System) -> Iterator[str]:
    """Yield the time, the parameters and the functions."""
    if system.time != ("k" if system.discrete else "t"):
        yield f"time: {scalar(system.time)}"
    if system.parameters:
        yield "parameters:"
        yield from block_lines([(one.name, _parameter(one)) for one in system.parameters])
    yield from signal_lines(system)
    relations = _relations(system)
    sampled = set(system.sampled)
    functions = [(one.name, _function(one, relations)) for one in system.functions]
    functions = [(name, said) for name, said in functions if said or name not in sampled]
    if any(said for _, said in functions):
        yield "functions:"
        yield from block_lines(functions)
    elif functions:
        yield from list_lines("functions", [scalar(name) for name, _ in functions])


def _parameter(one: Parameter) -> Value:
    assumed = "" if one.assume == "real" else one.assume
    rest = _texts({"unit": one.unit, "assume": assumed, "description": one.description})
    value = "null" if one.nominal is None else formula(one.nominal)
    return [*([("value", value)] if one.nominal is not None else []), *rest] if rest else value


def _texts(given: dict[str, str]) -> list[Entry]:
    return [(key, scalar(text)) for key, text in given.items() if text]


def _relations(system: System) -> dict[str, list[str]]:
    """Return the invariants by the function they are written under: the last one that occurs in them."""
    found: dict[str, list[str]] = {}
    for invariant in system.invariants:
        named = symbols(invariant.expression)
        under = [one.name for one in system.functions if one.name in named]
        if under:
            found.setdefault(under[-1], []).append(formula(invariant.expression))
    return found


def _function(one: Function, relations: dict[str, list[str]]) -> Value:
    entries: list[Entry] = [] if one.derivative is None else [("derivative", formula(one.derivative))]
    own = relations.get(one.name, [])
    if own:
        entries.append(("invariant", own[0] if len(own) == 1 else f"[{', '.join(own)}]"))
    return entries


def _states(system: System) -> Iterator[str]:
    described = [(one.name, _state(one)) for one in system.states]
    if any(value for _, value in described):
        yield "states:"
        yield from block_lines(described)
    else:
        yield from list_lines("states", [scalar(name) for name in system.state_names])
    for key, matrix, names in _driven(system):
        if matrix is not None and not _numbered(system, key, names):
            yield from list_lines({"B": "inputs", "G": "disturbances"}[key], [scalar(name) for name in names])


def _state(one: State) -> list[Entry]:
    latex = one.latex if len(one.latex) <= _LONGEST_LATEX else ""
    entries = _texts({"unit": one.unit, "description": one.description, "latex": latex})
    return entries if one.scale is None else [*entries, ("scale", formula(one.scale))]


def _driven(system: System) -> tuple[tuple[str, Matrix | None, tuple[str, ...]], ...]:
    return ("B", system.B, system.inputs), ("G", system.G, system.disturbances)


def _numbered(system: System, key: str, names: Sequence[str]) -> bool:
    """Whether columns must stay without names: those that they get then (u1, w1, …) are taken otherwise."""
    taken = {system.time, *system.state_names}
    taken |= {one.name for one in system.parameters} | {one.name for one in system.functions}
    if key == "G":
        taken |= set(system.inputs)
    return not names or not taken.isdisjoint(names)


def _matrices(system: System) -> Iterator[str]:
    states, outputs = system.state_names, tuple(output.name for output in system.outputs)
    yield from _sparse(system.dynamics_name, system.A, states, states, everything=False)
    if system.step is not None:
        yield f"step: {formula(system.step)}"
    yield from _sparse("H", system.H, outputs, states, everything=True)
    for key, matrix, names in _driven(system):
        if matrix is None:
            continue
        if _numbered(system, key, names):
            yield from _dense(key, matrix)
        else:
            yield from _sparse(key, matrix, states, names, everything=False)
    yield from _outputs(system)


def _outputs(system: System) -> Iterator[str]:
    """Yield what is said of outputs beside their rows."""
    described = [(one.name, _output(one)) for one in system.outputs]
    if any(entries for _, entries in described):
        yield from entry_lines("outputs", [one for one in described if one[1]])


def _output(one: Output) -> list[Entry]:
    entries = _texts({"unit": one.unit})
    if one.every is not None:
        entries.append(("every", formula(one.every)))
    if one.during is not None:
        spans = tuple(f"[{formula(start)}, {formula(stop)}]" for start, stop in one.during)
        entries.append(("during", Items(spans)))
    return entries


def _sparse(
    key: str, matrix: Matrix, rows: Sequence[str], columns: Sequence[str], *, everything: bool
) -> Iterator[str]:
    """Yield a matrix by names; ``everything``: rows without entries too, since their names matter."""
    found: dict[str, list[Entry]] = {name: [] for name in rows} if everything else {}
    for (i, j), entry in sorted(matrix.entries.items()):
        found.setdefault(rows[i], []).append((columns[j], formula(entry)))
    yield f"{key}:" if found else f"{key}: {{}}"
    yield from block_lines(list(found.items()))


def _dense(key: str, matrix: Matrix) -> Iterator[str]:
    yield f"{key}:"
    for i in range(matrix.rows):
        row = [matrix.entries.get((i, j)) for j in range(matrix.columns)]
        yield f"  - [{', '.join('0' if entry is None else formula(entry) for entry in row)}]"


def _interval(system: System) -> Iterator[str]:
    if system.interval is None:
        return
    ends: dict[str, Expression | None] = {"start": system.interval.start, "stop": system.interval.stop}
    entries: list[Entry] = [(key, formula(end)) for key, end in ends.items() if end is not None]
    if system.interval.samples is not None:
        entries.append(("samples", str(system.interval.samples)))
    if entries:
        yield from entry_lines("interval", entries)


def _quantities(system: System) -> Iterator[str]:
    if system.quantities:
        yield "quantities:"
        yield from block_lines([(one.name, _quantity(one, system)) for one in system.quantities])


def _quantity(one: Quantity, system: System) -> str:
    decimal = {state: with_decimals(entry) for state, entry in one.coefficients.items()}
    return scalar(covector_text(decimal, system.state_names))


def _expect(heading: Heading) -> Iterator[str]:
    if heading.rank is not None:
        yield "expect:"
        yield f"  - rank: {heading.rank}"
