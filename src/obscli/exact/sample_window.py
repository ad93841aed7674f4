"""A discrete-time system whose coefficients depend on the step, as one without dynamics: n samples at once.

    y(k+j) = L_j(k) x(k),    L_0 = H(k),  L_{j+1}(k) = L_j(k+1) F(k),    j = 0 … n − 1

k is anything that does not move: rank, combinations and directions of the rows L_j(k) are those of x(k), for
a generic k. The span V_j of L_0 … L_j over the functions of k satisfies V_{j+1} = V_0 + V_j(k+1) F, so that
once it stands it stands for ever: n samples are enough, for a singular F too. A generic k is a real number;
identities hold at whole ones, and a minor that is no identity vanishes at isolated ones only, except where
sines of multiples of π k stand: these are refused.
"""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from obscli.exact.errors import UndecidedError
from obscli.exact.exact_system import read_system
from obscli.exact.rows import combined
from obscli.exact.structure_finding import Structure
from obscli.model.discrete import is_time_invariant, repeating_entry
from obscli.model.expression import ONE, ZERO, Symbol, TimeDerivative, add, is_zero, multiply, substitute
from obscli.model.specialise import at_nominal
from obscli.model.system import Function, Matrix, Output


if TYPE_CHECKING:
    from obscli.exact.finding import Analysis, AtValues, Combination, CriticalSearch
    from obscli.model.expression import Expression
    from obscli.model.system import Covector, System

#: More rows than this are not put below each other.
_MOST_ROWS: Final = 400

MOVES: Final = "how the unobservable directions move depends on the step"
_GENERIC: Final = "The rank holds at generic steps; at single values of"
_REPEATS: Final = (
    "{} contains a sine or exponential of a multiple of pi*{}, which repeats at whole steps: give the phases "
    "as models of their own"
)


def is_window_needed(system: System) -> bool:
    """Whether a system is a discrete-time one whose coefficients depend on the step."""
    return system.discrete and not is_time_invariant(system)


def static(system: System) -> System:
    """Return a system in which linear forms of another can be compared: itself, or its window of samples.

    Raises
    ------
    UndecidedError : as ``sample_window``
    """
    return sample_window(system) if is_window_needed(system) else system


def sample_window(system: System) -> System:
    """Return x' = 0, y = (L_0(k); …; L_{n−1}(k)) x, with k a function of time, k' = 0.

    Raises
    ------
    UndecidedError : the samples are too many, or coefficients repeat at whole steps
    """
    if system.n * system.m > _MOST_ROWS:
        raise UndecidedError(f"{system.n} samples of {system.m} outputs are too many for exact algebra")
    where = repeating_entry(system)
    if where is not None:
        raise UndecidedError(_REPEATS.format(where, system.time))
    blocks = _blocks(system)
    entries = {
        (j * system.m + i, column): entry
        for j, block in enumerate(blocks)
        for i, row in enumerate(block)
        for column, entry in row.items()
    }
    index = Function(system.time, system.states[0].place, ZERO)  # whatever it is, it stays
    return replace(
        system,
        time=_unused(system),
        functions=(index,),
        outputs=tuple(_sample(system, one, j) for j in range(len(blocks)) for one in system.outputs),
        A=Matrix(system.n, system.n, {}),
        H=Matrix(len(blocks) * system.m, system.n, entries),
        B=None,
        G=None,
        inputs=(),
        disturbances=(),
        noise=None,
        interval=None,
        discrete=False,
        step=None,
    )


def _blocks(system: System) -> list[list[dict[int, Expression]]]:
    """Return L_0 … L_{n−1} as expressions, by rows."""
    rows: list[dict[int, Expression]] = [{} for _ in range(system.m)]
    for (i, j), entry in system.H.entries.items():
        rows[i][j] = entry
    blocks = [rows]
    for _ in range(system.n - 1):
        rows = [_times(system, {j: later(system, e) for j, e in row.items()}) for row in rows]
        blocks.append(rows)
    return blocks


def _times(system: System, row: dict[int, Expression]) -> dict[int, Expression]:
    """Return l F."""
    terms: dict[int, list[Expression]] = {}
    for (i, j), entry in system.A.entries.items():
        if i in row:
            terms.setdefault(j, []).append(multiply(row[i], entry))
    found = {j: add(*parts) for j, parts in terms.items()}
    return {j: entry for j, entry in found.items() if not is_zero(entry)}


def later(system: System, expression: Expression) -> Expression:
    """Return an expression at the next step."""
    nothing = TimeDerivative(system.time, {}, frozenset())
    return substitute(expression, {system.time: add(Symbol(system.time), ONE)}, nothing)


def _sample(system: System, output: Output, j: int) -> Output:
    return replace(output, name=sample_name(system, output.name, j), vector="", every=None, during=None)


def sample_name(system: System, output: str, j: int) -> str:
    """Return the name of the sample of an output j steps later: ``y1(k+2)``."""
    return f"{output}({system.time}{f'+{j}' if j else ''})"


def _unused(system: System) -> str:
    """Return a name for the time that passes between no two samples."""
    taken = {system.time, *system.state_names, *(one.name for one in system.parameters)}
    return next(name for name in ("t", *(f"t_{k}" for k in range(len(taken) + 1))) if name not in taken)


def of_window(system: System, found: Analysis) -> Analysis:
    """Return the analysis of a window of samples as that of its system.

    Raises
    ------
    UndecidedError : it cannot be decided what of it keeps its value
    """
    origin = {
        sample_name(system, one.name, j): (one.name, j) for j in range(system.n) for one in system.outputs
    }
    combinations = tuple(_combination(system, one, origin) for one in found.combinations)
    hidden = system.n - found.rank
    return replace(
        found,
        system=system,
        order=max((one.order for one in combinations), default=0),
        combinations=combinations,
        at_values=_at_values(system, found.at_values),
        critical=None if found.critical is None else _critical(system, found.critical),
        frozen_rank=None,
        varying=(f"the step {system.time}",),
        notes=(
            *found.notes,
            f"The rank holds at generic steps; at single values of {system.time} it may be lower.",
        ),
        structure=Structure(
            hidden, "undecided" if hidden else "observable", reason=MOVES, directions=found.unobservable
        ),
    )


def _critical(system: System, found: CriticalSearch) -> CriticalSearch:
    """Return the critical values without what is undecided of single steps: the rank is generic."""
    kept = tuple(
        one
        for one in found.values
        if one.kind in {"confirmed", "excluded"} or not _names_the_step(system, one.condition)
    )
    steps = f"single values of {system.time}, at which the rank may be lower"
    rest = tuple(one for one in found.not_searched if not _names_the_step(system, one))
    return replace(found, values=kept, complete=False, not_searched=(*rest, steps), instants=())


def _names_the_step(system: System, text: str) -> bool:
    return system.time in re.findall(r"\w+", text)


def _combination(system: System, one: Combination, origin: dict[str, tuple[str, int]]) -> Combination:
    output, order = origin[one.output]
    return replace(one, constant=_keeps(system, one.coefficients), output=output, order=order)


def _keeps(system: System, form: Covector) -> bool:
    """Whether ξ(k+1) F(k) = ξ(k)."""
    place = {name: j for j, name in enumerate(system.state_names)}
    now = {place[name]: entry for name, entry in form.items()}
    after = _times(system, {j: later(system, entry) for j, entry in now.items()})
    exact = read_system(sample_window(system), [*now.values(), *after.values()])
    read, one = exact.interpreter.read, exact.field.one
    rows = [(one, {j: read(e) for j, e in after.items()}), (-one, {j: read(e) for j, e in now.items()})]
    return not combined(exact.field, rows)


def _at_values(system: System, found: AtValues) -> AtValues:
    """Return the rank at the file's values, unless coefficients repeat at whole steps there."""
    where = repeating_entry(at_nominal(system).system())
    if where is None:
        return found
    return replace(found, rank=None, reason=_REPEATS.format(where, system.time), certificate=None)
