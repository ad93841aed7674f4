"""What segments show of the state at the start, exactly, where their transitions have a closed form.

Where A_j is constant and no state acts on itself, not through others either (the graph of A has no cycle),
it is nilpotent and

    e^(A s) = Σ_k A^k s^k / k!    (k < n)

so that every output is a known function of time of the state at the start,

    y(t) = H_j(t) e^(A_j (t − t_{j−1})) J_{j−1} e^(A_{j−1} Δ_{j−1}) … J_1 e^(A_1 Δ_1) x(t_0)

Together they are the outputs of x' = 0, whose observability is proved like any other: for generic parameters
and durations, and for this order of the segments.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import TypeAlias

from obscli.exact.analysis import Options, analyze
from obscli.exact.finding import Analysis, Undecided
from obscli.experiment.hidden_throughout import distinct, rows_of, static_with
from obscli.experiment.own_symbols import told_apart
from obscli.model.expression import (
    ONE,
    Expression,
    Number,
    Symbol,
    add,
    is_zero,
    multiply,
    negate,
    power,
    symbols,
)
from obscli.model.system import Covector, Matrix, Segments, System


Rows: TypeAlias = Mapping[str, Covector]


def outputs_from_start(
    segments: Segments, base: System, progress: Callable[[str], None]
) -> Analysis | Undecided | None:
    """Return the analysis of the outputs as functions of the state at the start.

    None where the transition of a segment has no closed form here.

    Parameters
    ----------
    base : the file's system, for its quantities and the values of its parameters
    """
    runs, _ = told_apart([one.run for one in segments.parts], segments.parts[0].system)
    systems = [run.system for run in runs]
    if not all(_is_nilpotent(one) for one in systems):
        return None
    names = systems[0].state_names
    carried: Rows = {name: {name: ONE} for name in names}
    begin = segments.start
    found: list[Covector] = []
    for one, system in zip(segments.parts, systems, strict=True):
        A = _by_row(system.A, names)
        since = add(Symbol(system.time), negate(begin))
        found += [_through(_evolved(row, A, since), carried) for row in rows_of(system.H, names)]
        through = {name: _evolved({name: ONE}, A, one.duration) for name in names}
        carried = {name: _through(row, carried) for name, row in through.items()}
        if one.jump is not None:
            jump = _by_row(one.jump, names)
            carried = {name: _through(jump.get(name, {}), carried) for name in names}
        begin = one.stop
    progress("outputs as functions of the state at the start")
    rows = list(distinct(row for row in found if row))
    return analyze(static_with(systems, rows, base), Options(critical=False, structure=False))


def _is_nilpotent(system: System) -> bool:
    """Whether A is constant and its graph has no cycle."""
    moving = {system.time, *(one.name for one in system.functions)}
    if symbols(*system.A.entries.values()) & moving:
        return False
    inputs: dict[int, set[int]] = {}
    for i, j in system.A.entries:
        inputs.setdefault(i, set()).add(j)
    while inputs:
        ready = [i for i, own in inputs.items() if not own & inputs.keys()]
        if not ready:
            return False
        for i in ready:
            del inputs[i]
    return True


def _by_row(matrix: Matrix, names: Sequence[str]) -> Rows:
    rows: dict[str, dict[str, Expression]] = {}
    for (i, j), entry in matrix.entries.items():
        rows.setdefault(names[i], {})[names[j]] = entry
    return rows


def _evolved(row: Covector, A: Rows, s: Expression) -> Covector:
    """Return row e^(A s), for A nilpotent."""
    total: dict[str, list[Expression]] = {}
    term, k, factorial = row, 0, 1
    while term:
        weight = multiply(Number(Fraction(1, factorial)), power(s, k))
        for name, entry in term.items():
            total.setdefault(name, []).append(multiply(weight, entry))
        term, k = _through(term, A), k + 1
        factorial *= k
    return _kept(total)


def _through(row: Covector, matrix: Rows) -> Covector:
    """Return row · matrix."""
    total: dict[str, list[Expression]] = {}
    for name, factor in row.items():
        for column, entry in matrix.get(name, {}).items():
            total.setdefault(column, []).append(multiply(factor, entry))
    return _kept(total)


def _kept(terms: Mapping[str, Sequence[Expression]]) -> Covector:
    total = {name: add(*own) for name, own in terms.items()}
    return {name: entry for name, entry in total.items() if not is_zero(entry)}
