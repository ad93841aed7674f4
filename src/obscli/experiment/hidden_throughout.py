"""An upper bound of what segments show together, proved: constant directions that stay hidden all the way.

A subspace K of states with, for every segment and all times,

    H_j(t) K = 0,    A_j(t) K ⊂ K,    J_j K ⊂ K

is never seen, however long the segments are and in whatever order: the rank is at most n − dim K. The largest
one is found from its covectors, those that are zero on K, by steps

    R_0 = span H_j(t),    R_{i+1} = R_i + R_i A_j(t) + R_i J_j    over all j and t

until nothing is added. Each span over time is what the outputs of x' = 0, y = M(t) x determine, which is
proved like any other observability. Where as many rows are seen to be independent, K is all that is hidden,
and R is the space of observable combinations.

References
----------
D. Goshen-Meskin, I. Y. Bar-Itzhack (1992), Observability analysis of piece-wise constant systems.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import TypeAlias

from obscli.exact.analysis import Options, analyze
from obscli.exact.finding import Analysis, Undecided
from obscli.experiment.own_symbols import OwnSymbol, told_apart
from obscli.model.expression import ONE, Expression, Symbol, add, is_zero, multiply
from obscli.model.notation import to_text
from obscli.model.specialise import Specialisation, at_nominal
from obscli.model.system import Covector, Function, Invariant, Matrix, Output, Parameter, Segments, System


Progress: TypeAlias = Callable[[str], None]

_STEP = Options(critical=False, certificate=False, structure=False)
_LAST = Options(critical=False, structure=False)


def hidden_throughout(segments: Segments, base: System, progress: Progress) -> Analysis | Undecided:
    """Return the analysis of x' = 0, y = R x, generic in the parameters: R the covectors that K is zero on.

    Parameters
    ----------
    base : the file's system, for its quantities and the values of its parameters
    """
    runs, own = told_apart([one.run for one in segments.parts], segments.parts[0].system)
    return _closed([run.system for run in runs], _jumps(segments, own), base, progress)


def hidden_there(segments: Segments, base: System, progress: Progress) -> Analysis | Undecided:
    """Return the same at the file's values, where more may stay hidden."""
    values = at_nominal(segments.parts[0].system)
    systems = [at_nominal(one.system).system() for one in segments.parts]
    jumps = [_exchanged(one.jump, values) for one in segments.parts if one.jump is not None]
    return _closed(systems, jumps, at_nominal(base).system(), progress)


def everything(segments: Segments, base: System) -> Analysis | Undecided:
    """Return the analysis of x' = 0, y = x: what there is to say where all states are seen."""
    system = segments.parts[0].system
    return analyze(static_with([system], [{name: ONE} for name in system.state_names], base), _LAST)


def _jumps(segments: Segments, own: Sequence[OwnSymbol]) -> list[Matrix]:
    """Return the jumps; they are in the parameters of the first segment, whose names those keep."""
    first = segments.parts[0]
    names: dict[str, Expression] = {one.of: Symbol(one.name) for one in own if first.name in one.runs}
    special = Specialisation(first.system, names)
    return [_exchanged(one.jump, special) for one in segments.parts if one.jump is not None]


def _exchanged(jump: Matrix, special: Specialisation) -> Matrix:
    entries = {at: special.expression(entry) for at, entry in jump.entries.items()}
    return replace(jump, entries={at: entry for at, entry in entries.items() if not is_zero(entry)})


def _closed(
    systems: Sequence[System], jumps: Sequence[Matrix], base: System, progress: Progress
) -> Analysis | Undecided:
    """Return the analysis of the last step."""
    moving = list({id(one): one for one in systems}.values())
    rows = list(distinct(row for one in moving for row in rows_of(one.H, one.state_names)))
    step = 0
    while True:
        progress(f"combinations that segments see, step {step}")
        found = analyze(static_with(moving, rows, base), _STEP)
        if isinstance(found, Undecided):
            return found
        reduced = [one.coefficients for one in found.combinations]
        further = list(distinct(_after(reduced, moving, jumps)))
        wider = analyze(static_with(moving, [*reduced, *further], base), _STEP)
        if isinstance(wider, Undecided):
            return wider
        if wider.rank == found.rank:
            break
        rows = [one.coefficients for one in wider.combinations]
        step += 1
    progress("combinations that segments see, proved")
    return analyze(static_with(moving, reduced, base), _LAST)


def _after(
    rows: Sequence[Covector], systems: Sequence[System], jumps: Sequence[Matrix]
) -> Iterator[Covector]:
    """Yield R A_j(t) and R J_j."""
    names = systems[0].state_names
    for matrix in (*(one.A for one in systems), *jumps):
        by_row: dict[str, list[tuple[str, Expression]]] = {}
        for (i, j), entry in matrix.entries.items():
            by_row.setdefault(names[i], []).append((names[j], entry))
        for row in rows:
            product: dict[str, list[Expression]] = {}
            for state, factor in row.items():
                for name, entry in by_row.get(state, ()):
                    product.setdefault(name, []).append(multiply(factor, entry))
            total = {name: add(*terms) for name, terms in product.items()}
            kept = {name: entry for name, entry in total.items() if not is_zero(entry)}
            if kept:
                yield kept


def rows_of(matrix: Matrix, names: Sequence[str]) -> Iterator[Covector]:
    """Yield the rows of a matrix that are not zero."""
    rows: dict[int, dict[str, Expression]] = {}
    for (i, j), entry in matrix.entries.items():
        rows.setdefault(i, {})[names[j]] = entry
    yield from rows.values()


def distinct(rows: Iterable[Covector]) -> Iterator[Covector]:
    """Yield each covector once, as written."""
    known: set[tuple[tuple[str, str], ...]] = set()
    for row in rows:
        text = tuple(sorted((name, to_text(entry)) for name, entry in row.items()))
        if text not in known:
            known.add(text)
            yield row


def static_with(systems: Sequence[System], rows: Sequence[Covector], base: System) -> System:
    """Return x' = 0, y = R(t) x with the names of all segments."""
    first = systems[0]
    column = {name: j for j, name in enumerate(first.state_names)}
    entries = {(i, column[name]): entry for i, row in enumerate(rows) for name, entry in row.items()}
    parameters: dict[str, Parameter] = {one.name: one for one in base.parameters}
    functions: dict[str, Function] = {}
    invariants: dict[str, Invariant] = {}
    for system in systems:
        parameters |= {one.name: one for one in system.parameters if one.name not in parameters}
        functions |= {one.name: one for one in system.functions}
        invariants |= {to_text(one.expression): one for one in system.invariants}
    place = first.states[0].place
    return replace(
        first,
        stage="segments",
        parameters=tuple(parameters.values()),
        functions=tuple(functions.values()),
        invariants=tuple(invariants.values()),
        outputs=tuple(Output(f"r{i}", place) for i in range(1, len(rows) + 1)),
        A=Matrix(first.n, first.n, {}),
        H=Matrix(len(rows), first.n, entries),
        B=None,
        G=None,
        inputs=(),
        disturbances=(),
        quantities=base.quantities,
        claims=(),
        noise=None,
    )
