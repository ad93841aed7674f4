"""What the command line changes: ``--set``, ``--fix``, ``--outputs``, ``--without``."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from obscli.model.draft import Draft, Entry, ParameterDraft
from obscli.model.expression import Expression
from obscli.model.form import ZERO_FORM
from obscli.model.formula import Formula, formula
from obscli.model.scope import Absent, Scope
from obscli.model.source import Source, checked
from obscli.model.system import Matrix, Noise, Output, Quantity, State, System
from obscli.model.tensor import Tensor
from obscli.model.tree import Scalar
from obscli.model.trouble import Problems, nearest, shown


MOST_LISTED: Final = 12


@dataclass(frozen=True, slots=True, eq=False)
class Options:
    """The options of ``load``."""

    fix: Mapping[str, str]
    settings: Mapping[str, str]
    outputs: Sequence[str]
    without: Sequence[str]
    freed: Collection[str] = ()


def freed(stage: Draft, options: Options) -> Draft:
    """Return a stage without the fixes that are to be undone."""
    return replace(stage, fix={name: entry for name, entry in stage.fix.items() if name not in options.freed})


def _assignment(option: str, name: str, text: str) -> tuple[Scalar, Scalar]:
    """Return name and text as nodes of the source ``name=text``."""
    source = checked(f"{name}={text}", option)
    width = len(name)
    return Scalar(source, 1, 1, name, name), Scalar(source, 1, width + 2, text, text)


def fixes(options: Options, problems: Problems) -> dict[str, Entry]:
    """Return the exact substitutions."""
    found = {}
    for name, text in options.fix.items():
        key, node = _assignment("--fix", name, text)
        found[name] = Entry(key, formula(node, name, problems))
    return found


def set_values(options: Options, draft: Draft, problems: Problems) -> Draft:
    """Return the nominal values as a stage of their own."""
    found = {}
    for name, text in options.settings.items():
        key, node = _assignment("--set", name, text)
        if name not in draft.parameters:
            near = nearest(name, draft.parameters)
            hint = "" if near else _listed(draft.parameters)
            problems.add(key.problem("", f"'{shown(name)}' is no parameter{near}", hint))
        value: Formula = formula(node, name, problems)
        found[name] = ParameterDraft(key, value)
    return Draft(draft.node, parameters=found)


def selected(system: System, options: Options, problems: Problems) -> System:
    """Return the system with the outputs asked for and without the states left out."""
    if options.outputs:
        rows = _positions("--outputs", options.outputs, system.outputs, problems)
        noise = system.noise
        system = replace(
            system,
            outputs=tuple(system.outputs[i] for i in rows),
            H=_taken(system.H, rows, range(system.n)),
            noise=noise and replace(noise, R=noise.R and _taken(noise.R, rows, rows)),
            claims=(),
        )
    if options.without:
        left_out = set(_positions("--without", options.without, system.states, problems))
        if len(left_out) == system.n:
            problems.add(
                Source("--without", ",".join(options.without)).problem(1, 1, 1, "", "no state is left")
            )
        system = _without(system, [i for i in range(system.n) if i not in left_out])
    return system


def _positions(
    option: str, names: Sequence[str], known: Sequence[State | Output], problems: Problems
) -> list[int]:
    """Return the positions of scalars, or of the components of vectors, in the order of the file."""
    wanted: set[int] = set()
    column = 1
    source = Source(option, ",".join(names))
    spellings = [spelling for one in known for spelling in (one.name, one.vector) if spelling]
    for name in names:
        found = {i for i, one in enumerate(known) if name in (one.name, one.vector)}
        if not found:
            what = "output" if option == "--outputs" else "state"
            near = nearest(name, spellings)
            message = f"'{shown(name)}' is no {what}{near}"
            hint = "" if near else _listed(spellings)
            problems.add(source.problem(1, column, len(name), "", message, hint))
        wanted |= found
        column += len(name) + 1
    return sorted(wanted)


def _listed(names: Iterable[str]) -> str:
    """Return the names there are, some of them where they are many."""
    known = list(dict.fromkeys(names))
    rest = f" and {len(known) - MOST_LISTED} more" if len(known) > MOST_LISTED else ""
    return f"there are: {', '.join(known[:MOST_LISTED])}{rest}" if known else "there are none"


def _taken(matrix: Matrix, rows: Sequence[int], columns: Sequence[int]) -> Matrix:
    """Return the rows and columns asked for."""
    row_of = {i: k for k, i in enumerate(rows)}
    column_of = {j: k for k, j in enumerate(columns)}
    kept = {
        key: (row_of[key[0]], column_of[key[1]])
        for key in matrix.entries
        if key[0] in row_of and key[1] in column_of
    }
    entries: dict[tuple[int, int], Expression] = {new: matrix.entries[old] for old, new in kept.items()}
    places = {new: matrix.places[old] for old, new in kept.items() if old in matrix.places}
    return Matrix(len(rows), len(columns), entries, places)


def _without(system: System, kept: list[int]) -> System:
    states = tuple(system.states[i] for i in kept)
    names = {state.name for state in states}
    return replace(
        system,
        scope=system.scope and _narrowed(system.scope, set(system.state_names) - names),
        states=states,
        A=_taken(system.A, kept, kept),
        H=_taken(system.H, range(system.m), kept),
        B=system.B and _taken(system.B, kept, range(system.B.columns)),
        G=system.G and _taken(system.G, kept, range(system.G.columns)),
        quantities=tuple(
            _restricted(one, names) for one in system.quantities if names & one.coefficients.keys()
        ),
        noise=system.noise and _narrowed_noise(system.noise, kept),
        prior={name: entry for name, entry in system.prior.items() if name in names},
        claims=(),
    )


def _narrowed_noise(noise: Noise, kept: list[int]) -> Noise:
    """Return the noise of the states kept: their prior, and what drives them."""
    Q = noise.Q and (_taken(noise.Q, kept, kept) if noise.driven == "states" else noise.Q)
    return replace(noise, Q=Q, P0=noise.P0 and _taken(noise.P0, kept, kept))


def _narrowed(scope: Scope, left_out: set[str]) -> Scope:
    """Return the scope in which states left out are 0 in vectors and unknown by themselves."""
    values = dict(scope.values)
    absent = dict(scope.absent)
    for name, value in scope.values.items():
        if not any(left_out & form.linear.keys() for form in value.entries):
            continue
        if value.shape:
            kept = (ZERO_FORM if left_out & form.linear.keys() else form for form in value.entries)
            values[name] = Tensor(value.shape, tuple(kept))
        else:
            del values[name]
            absent[name] = Absent(f"the state '{name}' is left out (--without)")
    return replace(scope, values=values, absent=absent)


def _restricted(one: Quantity, names: set[str]) -> Quantity:
    return replace(one, coefficients={name: node for name, node in one.coefficients.items() if name in names})
