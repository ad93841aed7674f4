"""What a coefficient may be made of: functions of time and monomials of parameters, all from the model.

Functions of time: 1, t, t², sin and cos of every angle in A and H, of its double, of sums and differences of
two, its tangent; exponentials and their inverses; roots, powers and logarithms that the model contains, and
its functions; products of t with the oscillating ones. Monomials: Π p^e over the parameters p and the sines
and cosines of constant angles, with small exponents, times a small rational number.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from typing import Final

import numpy as np

from obscli.model.expression import (
    ONE,
    Apply,
    Expression,
    Power,
    Symbol,
    add,
    multiply,
    negate,
    number,
    postorder,
    power,
    symbols,
)
from obscli.model.notation import to_text
from obscli.model.system import System
from obscli.numeric.program import Array, Program, Value


_MOST_FUNCTIONS: Final = 64
_MOST_ATOMS: Final = 9
_LARGEST_EXPONENT: Final = 2
_LARGEST_DEGREE: Final = 4
_RATIONALS: Final = tuple(Fraction(n, d) for n, d in ((1, 1), (2, 1), (1, 2), (3, 1), (1, 3), (4, 1), (1, 4)))
_SAME: Final = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Monomial:
    """A product of parameters: its expression, its value, and how many factors it has."""

    expression: Expression
    value: float
    degree: int


def functions_of_time(system: System) -> list[Expression]:
    """Return the functions of time that coefficients may be combined from, the simplest first."""
    time = Symbol(system.time)
    roots = [*system.A.entries.values(), *system.H.entries.values()]
    moving = {system.time} | {one.name for one in system.functions}
    nodes = [node for node in postorder(*roots) if symbols(node) & moving]
    angles = _distinct(
        n.argument for n in nodes if isinstance(n, Apply) and n.function in {"sin", "cos", "tan"}
    )
    doubled = [multiply(number(2), one) for one in angles]
    mixed = [sign for a, b in combinations(angles, 2) for sign in (add(a, b), add(a, negate(b)))]
    waves = [Apply(f, one) for one in (*angles, *doubled, *mixed) for f in ("sin", "cos")]
    others = [
        n
        for n in nodes
        if isinstance(n, Power) or (isinstance(n, Apply) and n.function not in {"sin", "cos"})
    ]
    named = [Symbol(one.name) for one in system.functions]
    growing = [one for n in (*others, *named) for one in (n, power(n, -1))]
    tangents = [Apply("tan", one) for one in angles]
    found = _distinct([
        ONE, time, power(time, 2), *waves, *growing, *tangents, *(multiply(time, one) for one in waves),
    ])  # fmt: skip
    return found[:_MOST_FUNCTIONS]


def monomials(system: System, constants: dict[str, float]) -> list[Monomial]:
    """Return the monomials of the parameters, the simplest first."""
    roots = [*system.A.entries.values(), *system.H.entries.values()]
    moving = {system.time} | {one.name for one in system.functions}
    steady = [n for n in postorder(*roots) if isinstance(n, Apply) and symbols(n) and not symbols(n) & moving]
    angles = _distinct(n.argument for n in steady if n.function in {"sin", "cos"})
    used = symbols(*roots)
    atoms: list[Expression] = [Symbol(one.name) for one in system.parameters if one.name in used]
    atoms += [Apply(f, one) for one in angles for f in ("sin", "cos")]
    values = [float(value) for value in Program(atoms).run(constants)]
    usable = [(a, v) for a, v in zip(atoms, values, strict=True) if v and math.isfinite(v)]
    return sorted(_products(usable[:_MOST_ATOMS]), key=lambda one: one.degree)


def _products(atoms: Sequence[tuple[Expression, float]]) -> Iterator[Monomial]:
    for exponents in _exponents(len(atoms), _LARGEST_DEGREE):
        pairs = [(a, v, e) for (a, v), e in zip(atoms, exponents, strict=True) if e]
        value = math.prod(v**e for _, v, e in pairs)
        degree = sum(abs(e) for _, _, e in pairs)
        if not 0 < abs(value) < math.inf:
            continue
        plain = multiply(*(power(a, e) for a, _, e in pairs)) if pairs else ONE
        for rational in _RATIONALS:
            extra = int(rational != 1)
            yield Monomial(multiply(number(rational), plain), float(rational) * value, degree + extra)


def _exponents(count: int, degree: int) -> Iterator[tuple[int, ...]]:
    """Yield the exponent vectors with small entries and a small sum of their sizes."""
    if count == 0:
        yield ()
        return
    for e in range(-min(degree, _LARGEST_EXPONENT), min(degree, _LARGEST_EXPONENT) + 1):
        for rest in _exponents(count - 1, degree - abs(e)):
            yield (e, *rest)


def _distinct(expressions: Iterator[Expression] | Sequence[Expression]) -> list[Expression]:
    """Return expressions that are written differently, in order."""
    return list({to_text(one): one for one in expressions}.values())


def independent(
    functions: Sequence[Expression], values: Sequence[Value], count: int
) -> tuple[list[Expression], Array]:
    """Return the functions that are finite at all instants and not multiples of an earlier one, with values.

    Returns
    -------
    functions, and their values, shape (count, len(functions))
    """
    kept: list[Expression] = []
    columns: list[Array] = []
    units: list[Array] = []
    for one, value in zip(functions, values, strict=True):
        column = np.array(np.broadcast_to(value, (count,)), dtype=float)
        size = np.linalg.norm(column)
        if not np.isfinite(size) or size == 0:
            continue
        unit = column / size
        if all(1 - abs(float(unit @ other)) > _SAME for other in units):
            kept.append(one)
            columns.append(column)
            units.append(unit)
    return kept, np.array(columns).T.reshape(count, len(kept))
