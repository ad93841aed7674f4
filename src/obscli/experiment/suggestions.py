"""Which kind of further run would determine what no candidate does: tried, not guessed.

Every candidate is done again with one thing changed: the body turned in an orientation matrix of the file
(every signed permutation of the axes, which covers "axis up and down" and "another axis"), a parameter with
the opposite sign, or with another value. A matrix of `let` is an orientation if it is a rotation at a random
point.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import permutations, product
from typing import Final, TypeAlias

from obscli.core.number import bar
from obscli.exact.finding import Undecided
from obscli.exact.row_sets import RowSets
from obscli.exact.without import rows_without
from obscli.experiment.limits import MOST_VARIED
from obscli.experiment.own_symbols import unused_name
from obscli.experiment.stacked import RunRows, static_system
from obscli.model.expression import (
    ZERO,
    Apply,
    Expression,
    Pi,
    Symbol,
    multiply,
    negate,
    number,
    postorder,
    symbols,
)
from obscli.model.specialise import Specialisation
from obscli.model.system import Parameter, Run, System
from obscli.numeric.program import constant_value


Progress: TypeAlias = Callable[[str], None]

#: Variants of runs that are tried; so many kinds that determine all are enough.
MOST_TRIALS: Final = 400
ENOUGH: Final = 3

#: Angles at which parameters in sines and cosines are tried.
RIGHT_ANGLES: Final[Mapping[str, Expression]] = {
    "0": ZERO,
    "pi/2": multiply(number(Fraction(1, 2)), Pi()),
    "pi": Pi(),
    "-pi/2": multiply(number(Fraction(-1, 2)), Pi()),
}

#: Decimals to which a matrix has to be a rotation.
_ROTATION: Final = 1e-9


@dataclass(frozen=True, slots=True)
class Suggestion:
    """A kind of run, in words, and the rank that all candidates reach with their variants of this kind."""

    words: str
    rank: int
    tried: int


def suggestions(
    runs: Sequence[RunRows], shared: Sequence[str], progress: Progress
) -> tuple[tuple[Suggestion, ...], tuple[str, ...]]:
    """Return the kinds of runs that reach a larger rank, the best first, and the kinds that were tried.

    Parameters
    ----------
    runs : the candidates with their rows
    shared : the states that they share
    """
    bases = _different(runs)[:MOST_VARIED]
    kinds = list(_kinds([one.run for one in bases]))
    kinds = kinds[: max(MOST_TRIALS // len(bases), 1)]
    rank, whole = _rank(runs, (), shared), len(shared)
    found: list[Suggestion] = []
    tried = []
    for k, (words, change) in enumerate(kinds, start=1):
        if sum(one.rank == whole for one in found) == ENOUGH:
            break
        tried.append(words)
        progress(f"what would determine the rest: {bar(k, len(kinds))} {words}")
        variants = [rows for one in bases for rows in _rows(one.run, change(one.run), shared)]
        reached = _rank(runs, variants, shared)
        if reached > rank:
            found.append(Suggestion(words, reached, len(variants)))
    found.sort(key=lambda one: -one.rank)
    return tuple(found), tuple(tried)


def _different(runs: Sequence[RunRows]) -> list[RunRows]:
    seen: dict[int, RunRows] = {}
    for one in runs:
        seen.setdefault(id(one.run.system), one)
    return list(seen.values())


def _rank(runs: Sequence[RunRows], variants: Sequence[RunRows], shared: Sequence[str]) -> int:
    everything = (*runs, *variants)
    return RowSets(static_system(everything, shared), [len(one.rows) for one in everything]).rank(
        range(len(everything))
    )


def _rows(run: Run, system: System | None, shared: Sequence[str]) -> Iterator[RunRows]:
    """Yield the rows of a variant, where it exists and can be analysed."""
    if system is None:
        return
    kept = frozenset(shared)
    rows = rows_without(system, [name for name in system.state_names if name not in kept])
    if not isinstance(rows, Undecided):
        yield RunRows(replace(run, system=system), rows)


Change: TypeAlias = Callable[[Run], System | None]


def _kinds(runs: Sequence[Run]) -> Iterator[tuple[str, Change]]:
    """Yield every kind of change in words, and as what makes the system: signs and half turns first."""
    system = runs[0].system
    turns = [
        (f"{words} (in `{name}`)", _turn(name, matrix))
        for name in orientations(system)
        for words, matrix in _turns()
    ]
    halves = [one for one in turns if "half a turn" in one[0]]
    parameters = _in_use(runs)
    for name, one in parameters.items():
        if one.assume != "positive":
            yield f"{name} with the opposite sign", _with(name, negate(Symbol(name)))
    yield from halves
    angles = _angles(runs)
    for name in parameters:
        for text, value in RIGHT_ANGLES.items() if name in angles else ():
            yield f"{name} = {text}", _with(name, value)
    yield from (one for one in turns if one not in halves)
    for name in parameters:
        other = unused_name(name, [run.system for run in runs])
        yield f"another generic value of {name}", _with(name, None, other)


def _in_use(runs: Sequence[Run]) -> dict[str, Parameter]:
    """Return the parameters that some run depends on, those that it fixes too."""
    found: dict[str, Parameter] = {}
    for run in runs:
        for system in (run.system, *(free for name in run.fixed if (free := _freed(run, name)) is not None)):
            used = symbols(*system.A.entries.values(), *system.H.entries.values())
            found |= {
                one.name: one for one in system.parameters if one.name in used and one.name not in found
            }
    return found


def _freed(run: Run, name: str) -> System | None:
    return None if run.freed is None else run.freed(name)


def _angles(runs: Sequence[Run]) -> frozenset[str]:
    """Return the names that stand in a sine or cosine without the time."""
    found: set[str] = set()
    for run in runs:
        for system in (run.system, *(free for name in run.fixed if (free := _freed(run, name)) is not None)):
            roots = [*system.A.entries.values(), *system.H.entries.values()]
            for node in postorder(*roots):
                if isinstance(node, Apply) and node.function in {"sin", "cos"}:
                    names = symbols(node.argument)
                    found |= names if system.time not in names else set()
    return frozenset(found)


def _turn(name: str, matrix: str) -> Change:
    return lambda run: None if run.turned is None else run.turned(name, matrix)


def _with(name: str, value: Expression | None, other: str = "") -> Change:
    """Return the change of one parameter, None: to a symbol of its own, ``other``."""

    def change(run: Run) -> System | None:
        system = _freed(run, name) if name in run.fixed else run.system
        if system is None or name not in {one.name for one in system.parameters}:
            return None
        new: Expression = Symbol(other) if value is None else value
        special = Specialisation(system, {name: new}).system()
        own = tuple(
            replace(one, name=other) if value is None and one.name == name else one
            for one in system.parameters
        )
        return replace(special, parameters=own)

    return change


def orientations(system: System) -> list[str]:
    """Return the names of `let` that are rotations at a random point."""
    if system.scope is None:
        return []
    values = _random_values(system)
    found = []
    for name, tensor in system.scope.values.items():
        if tensor.shape != (3, 3) or any(form.linear for form in tensor.entries):
            continue
        try:
            entries = [constant_value(form.constant, values) for form in tensor.entries]
        except (KeyError, TypeError, ValueError, ZeroDivisionError, OverflowError):
            continue
        if _is_rotation([entries[3 * i : 3 * i + 3] for i in range(3)]):
            found.append(name)
    return found


def _random_values(system: System) -> Mapping[str, float]:
    source = random.Random(7)  # noqa: S311  (a point to look at, no secret)
    names = [system.time, *(one.name for one in system.parameters), *(one.name for one in system.functions)]
    return {name: source.uniform(0.3, 1.3) for name in names}


def _is_rotation(rows: Sequence[Sequence[float]]) -> bool:
    gram = [[sum(a * b for a, b in zip(x, y, strict=True)) for y in rows] for x in rows]
    wanted = [[float(i == j) for j in range(3)] for i in range(3)]
    close = all(
        abs(g - w) < _ROTATION for x, y in zip(gram, wanted, strict=True) for g, w in zip(x, y, strict=True)
    )
    (a, b, c), (d, e, f), (g, h, i) = rows
    return close and a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) > 0


def _turns() -> Iterator[tuple[str, str]]:
    """Yield the 23 rotations that permute the axes, half turns first, in words and as a matrix."""
    found = []
    for order in permutations(range(3)):
        for signs in product((1, -1), repeat=3):
            rows = [[signs[i] if order[i] == j else 0 for j in range(3)] for i in range(3)]
            trace = sum(rows[i][i] for i in range(3))
            if _is_rotation(rows) and trace < 3:
                found.append((trace, _words(rows, trace), str(rows)))
    for _, words, matrix in sorted(found, key=lambda one: (abs(one[0] + 1), one[1])):
        yield words, matrix


def _words(rows: Sequence[Sequence[int]], trace: int) -> str:
    """Return the rotation in words: new axes of the body in terms of the old ones."""
    fixed = [i + 1 for i in range(3) if rows[i][i] == 1]
    axes = [f"{'-' if rows[i][j] < 0 else ''}{i + 1}" for j in range(3) for i in range(3) if rows[i][j]]
    listed = f"axes {', '.join(axes)} in place of 1, 2, 3"
    if trace == -1 and fixed:
        return f"the body turned by half a turn about its axis {fixed[0]}"
    if trace == 1:
        return f"the body turned by a quarter turn about its axis {fixed[0]}, {listed}"
    return f"the body turned, {listed}"
