"""How the unobservable subspace moves by itself: z' = A22 z, x = N z.

With the columns of N scaled to 1 at the free states, z are the free states themselves and

    A22 = A_f N                     (the rows of A of the free states f)

With the columns scaled by D as they are printed (z = D z̃):  Ã22 = D⁻¹ (A22 D − D').  Of the two the one
is taken in which A22 does not depend on time; only then its eigenvalues mean something.

Where A22 is constant every hidden solution is x = N(t) e^{A22 t} z0. If N is made of polynomials in t, sines
and cosines of constant rates, x dies out exactly if A22 is Hurwitz. If N is made of anything else, x does
not die out where A22 is not Hurwitz and z are free states, which are part of x; the rest is open.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

from obscli.exact.field import Element
from obscli.exact.rows import dot, field_row, transpose


if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from obscli.exact.exact_system import Row
    from obscli.exact.field import Field
    from obscli.exact.prove import Proof


@dataclass(frozen=True, slots=True, eq=False)
class HiddenDynamics:
    """A22 (d, d) by rows and the columns of N, in one of two scalings.

    ``decides``: what the eigenvalues of A22 decide: everything, only that an error does not die out, or
    nothing (A22 depends on time).
    """

    columns: tuple[Row, ...]
    matrix: tuple[Row, ...]
    decides: Literal["all", "growth", "nothing"]


def hidden_dynamics(proof: Proof) -> HiddenDynamics:
    """Return A22 in the coordinates in which it is constant, if there are such."""
    free = _by_free_states(proof)
    printed = _as_printed(proof, free)
    field = proof.exact.field
    if all(is_constant(field, row) for row in printed.matrix) and _is_trigonometric(proof, printed.columns):
        return replace(printed, decides="all")
    if all(is_constant(field, row) for row in free.matrix):
        return replace(free, decides="growth")
    return free


def constant_part(field: Field, dynamics: HiddenDynamics) -> HiddenDynamics:
    """Return the dynamics on directions that move by constant coefficients among themselves.

    The largest set of columns of A22 that are constant and zero in the rows of all other columns: solutions
    that start there stay there.
    """
    columns = transpose(dynamics.matrix, len(dynamics.matrix))
    kept = {k for k, column in enumerate(columns) if is_constant(field, column)}
    while True:
        closed = {k for k in kept if columns[k].keys() <= kept}
        if closed == kept:
            break
        kept = closed
    place = {k: position for position, k in enumerate(sorted(kept))}
    rows = tuple({place[j]: dynamics.matrix[k][j] for j in place if j in dynamics.matrix[k]} for k in place)
    return HiddenDynamics(tuple(dynamics.columns[k] for k in place), rows, "growth")


def transposed(dynamics: HiddenDynamics) -> HiddenDynamics:
    """Return the same with A22 transposed: its closed columns are free states that move by themselves."""
    return replace(dynamics, matrix=transpose(dynamics.matrix, len(dynamics.matrix)))


def _by_free_states(proof: Proof) -> HiddenDynamics:
    exact, field = proof.exact, proof.exact.field
    columns = []
    for f, column in proof.kernel.columns.items():
        one = Element(field, column[f], field.one_polynomial)
        columns.append({j: entry / one for j, entry in field_row(field, column).items()})
    rows = [
        {k: dot(field, exact.A[f], column) for k, column in enumerate(columns)} for f in proof.kernel.columns
    ]
    return HiddenDynamics(tuple(columns), tuple(_without_zeros(row) for row in rows), "nothing")


def _as_printed(proof: Proof, free: HiddenDynamics) -> HiddenDynamics:
    """Scale the columns as they are printed."""
    exact, field = proof.exact, proof.exact.field
    names = exact.system.state_names
    scales = [exact.interpreter.read(proof.directions[f][names[f]]) for f in proof.kernel.columns]
    columns = tuple(
        {j: entry * scale for j, entry in column.items()}
        for column, scale in zip(free.columns, scales, strict=True)
    )
    rows = []
    for k, row in enumerate(free.matrix):
        scaled = {m: entry * scales[m] / scales[k] for m, entry in row.items()}
        scaled[k] = scaled.get(k, field.zero) - field.derive(scales[k]) / scales[k]
        rows.append(_without_zeros(scaled))
    return HiddenDynamics(columns, tuple(rows), "nothing")


def _without_zeros(row: Row) -> Row:
    return {k: entry for k, entry in row.items() if entry}


def is_constant(field: Field, row: Row) -> bool:
    """Whether no entry of a row varies in time."""
    return not any(field.varies(k) for entry in row.values() for k in occurring(entry))


def occurring(element: Element) -> set[int]:
    """Return the indices of the generators in an element."""
    tops = zip(element.num.degrees(), element.den.degrees(), strict=True)
    return {k for k, degrees in enumerate(tops) if max(degrees) > 0}


def _is_trigonometric(proof: Proof, columns: Iterable[Mapping[int, Element]]) -> bool:
    """Whether columns, as printed, vary by powers of time, sines and cosines of constant rates alone."""
    field = proof.exact.field
    found = {k for column in columns for entry in column.values() for k in occurring(entry)}
    varying = [k for k in found if field.varies(k)]
    return all(field.generators[k].kind == "time" or rate(proof, k) is not None for k in varying)


def rate(proof: Proof, k: int) -> Element | None:
    """Return the rate of the base angle of a generator where it is constant; None for other generators."""
    exact, field = proof.exact, proof.exact.field
    generator = field.generators[k]
    if generator.kind != "angle" or generator.argument is None:
        return None
    derivative = field.derive(exact.interpreter.read(generator.argument))
    return None if any(field.varies(g) for g in occurring(derivative)) else derivative
