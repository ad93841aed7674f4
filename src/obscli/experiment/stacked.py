"""What runs determine about the states they share, exactly: reduced bases of each run, stacked.

The observable covectors of run i that are zero on the states that start anew (those of L_i with zeros there)
form a space that differentiation keeps; its reduced echelon form M_i is therefore constant. A combination of
the shared constants is determined by several runs if it lies in the row space of

    M = (M_1; …; M_k)

Covectors that need the other states are of no use: these differ from run to run.

References
----------
V. M. Morozov, F. Yu. Baklanov (2018), the calibration example: the matrix M.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeAlias

from obscli.exact.analysis import Options, analyze
from obscli.exact.finding import Analysis, StateVerdict, Undecided
from obscli.exact.without import rows_without
from obscli.model.expression import symbols
from obscli.model.specialise import at_nominal
from obscli.model.system import Covector, Matrix, Output, Parameter, Quantity, Run, System


Progress: TypeAlias = Callable[[str], None]


@dataclass(frozen=True, slots=True, eq=False)
class RunRows:
    """One run and its rows M_i, or why there are none; ``finding``: its whole analysis, where it is made."""

    run: Run
    rows: tuple[Covector, ...]
    undecided: str = ""
    finding: Analysis | Undecided | None = None

    def verdict(self, state: str) -> StateVerdict | None:
        """Return what this run alone says of a shared state; None where it is undecided."""
        if self.undecided:
            return None
        rows = [row for row in self.rows if state in row]
        if any(len(row) == 1 for row in rows):
            return "observable"
        return "coupled" if rows else "unobservable"


@dataclass(frozen=True, eq=False)
class Stack:
    """The runs and M = (M_1; …; M_k) as a system of its own: states the shared ones, A = 0, H = M.

    Parameters
    ----------
    runs : each run with its rows
    system : x' = 0, y = M x, one output a row
    finding : its analysis, or why there is none
    """

    runs: tuple[RunRows, ...]
    system: System
    finding: Analysis | Undecided

    @cached_property
    def adds(self) -> tuple[tuple[Covector, ...], ...]:
        """The rows of every run that are independent of all rows before them."""
        if not isinstance(self.finding, Analysis) or self.finding.certificate is None:
            return tuple(() for _ in self.runs)
        new = {output for output, _ in self.finding.certificate.lower.rows}
        names = iter(output.name for output in self.system.outputs)
        return tuple(tuple(row for row in one.rows if next(names) in new) for one in self.runs)


class Memo:
    """Rows and systems that several questions about the same runs need, found once each."""

    def __init__(self) -> None:
        self._rows: dict[tuple[int, tuple[str, ...]], RunRows] = {}
        self._nominal: dict[int, tuple[System, System]] = {}

    def rows(self, run: Run, shared: tuple[str, ...]) -> RunRows:
        """Return the rows of a run; ``run`` is what the memo remembers them with."""
        key = (id(run.system), shared)
        if key not in self._rows:
            self._rows[key] = _proved_rows(run, frozenset(shared))
        return self._rows[key]

    def nominal(self, system: System) -> System:
        """Return the system with its parameters replaced by their values."""
        if id(system) not in self._nominal:
            self._nominal[id(system)] = (system, at_nominal(system).system())
        return self._nominal[id(system)][1]


def analysed(
    runs: Sequence[Run],
    shared: Sequence[str],
    progress: Progress,
    *,
    critical: bool,
    base: System | None = None,
) -> Stack:
    """Analyse every run, and what all determine together.

    Parameters
    ----------
    runs : with the same states; a parameter has the same meaning in all of them
    shared : the states that they share, constant in all of them
    critical : whether to search for values at which ranks may drop
    base : the file's system, whose quantities are judged
    """
    kept = frozenset(shared)

    def rows_of(run: Run) -> RunRows:
        fresh = tuple(name for name in run.system.state_names if name not in kept)
        options = Options(pivot_order=fresh, critical="candidates" if critical else False, structure=False)
        finding = analyze(run.system, options, lambda step: progress(f"{run.name}: {step}"))
        if isinstance(finding, Undecided):
            return RunRows(run, (), finding.reason, finding)
        return replace(_told_by(run, _constant_rows(finding, kept)), finding=finding)

    found = _each_once(runs, rows_of)
    progress("all runs together")
    return stacked(
        found, shared, Options(critical="candidates" if critical else False, structure=False), base
    )


def proved(
    runs: Sequence[Run],
    shared: Sequence[str],
    told: Callable[[int, str], None] = lambda _k, _name: None,
    base: System | None = None,
    memo: Memo | None = None,
) -> Stack:
    """Return only what the runs determine, without a report on each.

    Parameters
    ----------
    told : told which run is looked at, counted from 1, and its name
    base : the file's system, for its quantities and the values of its parameters
    memo : of what was found before
    """
    memo = memo or Memo()
    place = {id(run): k for k, run in enumerate(runs, start=1)}

    def rows_of(run: Run) -> RunRows:
        told(place[id(run)], run.name)
        return memo.rows(run, tuple(shared))

    return stacked(_each_once(runs, rows_of), shared, Options(critical=False), base)


def _proved_rows(run: Run, shared: frozenset[str]) -> RunRows:
    rows = rows_without(run.system, [name for name in run.system.state_names if name not in shared])
    return RunRows(run, (), rows.reason) if isinstance(rows, Undecided) else _told_by(run, rows)


def _each_once(runs: Sequence[Run], rows_of: Callable[[Run], RunRows]) -> tuple[RunRows, ...]:
    """Return the rows of every run; runs that are the same system are looked at once."""
    known: dict[int, RunRows] = {}
    found = []
    for run in runs:
        if id(run.system) not in known:
            known[id(run.system)] = rows_of(run)
        found.append(replace(known[id(run.system)], run=run))
    return tuple(found)


def _told_by(run: Run, rows: tuple[Covector, ...]) -> RunRows:
    """Return the rows; undecided where a function without a value is in them, that stands still in it."""
    functions = {one.name for one in run.system.functions}
    inside = sorted(functions & symbols(*(entry for row in rows for entry in row.values())))
    if not inside:
        return RunRows(run, rows)
    names = ", ".join(inside)
    return RunRows(run, (), f"what it determines depends on {names}, constant there: give a value with `fix`")


def _constant_rows(finding: Analysis, shared: frozenset[str]) -> tuple[Covector, ...]:
    """Return M_i: the combinations without any state that starts anew; they do not vary."""
    rows = [one for one in finding.combinations if shared.issuperset(one.coefficients)]
    assert all(one.constant for one in rows)
    return tuple(one.coefficients for one in rows)


def stacked(
    runs: tuple[RunRows, ...], shared: Sequence[str], options: Options, base: System | None = None
) -> Stack:
    """Put the rows of all runs below each other and analyse the matrix."""
    system = static_system(runs, shared, base)
    for one in runs:
        if one.undecided:
            return Stack(runs, system, Undecided(system, f"run {one.run.name}: {one.undecided}"))
    return Stack(runs, system, analyze(system, options))


def static_system(runs: Sequence[RunRows], shared: Sequence[str], base: System | None = None) -> System:
    """Return x' = 0, y = M x.

    Parameters
    ----------
    base : the file's system, for its quantities: those of a run may have parameters fixed
    """
    first = runs[0].run.system
    kept = frozenset(shared)
    states = tuple(one for one in first.states if one.name in kept)
    column = {one.name: j for j, one in enumerate(states)}
    parameters: dict[str, Parameter] = {one.name: one for one in (base.parameters if base else ())}
    entries = {}
    outputs: list[Output] = []
    for k, one in enumerate(runs, start=1):
        for parameter in one.run.system.parameters:
            parameters.setdefault(parameter.name, parameter)
        for i, row in enumerate(one.rows, start=1):
            entries.update({(len(outputs), column[name]): entry for name, entry in row.items()})
            outputs.append(Output(f"run{k}_{i}", one.run.place))
    n = len(states)
    return System(
        stage="experiment",
        time=first.time,
        parameters=tuple(parameters.values()),
        functions=(),
        invariants=(),
        states=states,
        outputs=tuple(outputs),
        A=Matrix(n, n, {}),
        H=Matrix(len(outputs), n, entries),
        quantities=tuple(_about(base.quantities if base else (), kept)),
        prior={name: entry for name, entry in first.prior.items() if name in kept},
        scope=first.scope,
    )


def _about(quantities: Sequence[Quantity], shared: frozenset[str]) -> Iterator[Quantity]:
    """Yield the quantities that are combinations of shared states alone."""
    yield from (one for one in quantities if shared.issuperset(one.coefficients))
