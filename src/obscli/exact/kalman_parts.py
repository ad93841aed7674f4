"""The basis of the structural decomposition: T = [T_1 | T_2 | T_3 | T_4] and its inverse.

With S the reduced echelon form of the observable covectors, pivots p, and N = ker S with free states f, the
coordinates z_p = S_p x and x_f change over to x by

    T_0 = [e_p / S_pp  by pivot | N_f / N_ff  by free state]

In (z, x_f) the reachable subspace has a reduced echelon form with pivots in z first. Its vectors with pivots
in x_f lie in N and are T_1, the others T_2; unit vectors complete them: T_3 in x_f, T_4 in z.
So T = T_0 (1 + E), where E takes T_1 and T_2 to the coordinates of T_3 and T_4; E² = 0 and
T⁻¹ = (1 − E) T_0⁻¹.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

from obscli.exact.echelon import polynomial_row, reduced_echelon
from obscli.exact.field import Element
from obscli.exact.nonzero import require_nonzero
from obscli.exact.reachable import reachable_rows
from obscli.exact.rows import combined, dot, field_row
from obscli.model.acting import Inputs


if TYPE_CHECKING:
    from collections.abc import Sequence

    from obscli.exact.exact_system import Row
    from obscli.exact.prove import Proof

#: Vectors of one part by their pivots in the coordinates (z, x_f), 1 there.
Part: TypeAlias = "dict[int, Row]"


def reach(proof: Proof, inputs: Inputs) -> Part:
    """Return the reduced echelon form of the reachable subspace in the coordinates (z, x_f).

    Raises
    ------
    UndecidedError : the reachable subspace cannot be decided
    JetOverflowError : more derivatives of a function are needed than the field holds
    """
    field, interpreter = proof.exact.field, proof.exact.interpreter
    known = reachable_rows(proof.exact, inputs)
    if len(known) == proof.exact.n:
        return {j: {j: field.one} for j in known}
    changed = (_changed(proof, field_row(field, vector)) for vector in known.values())
    columns = [*sorted(proof.flag.rows), *proof.kernel.columns]
    found = reduced_echelon(field, (polynomial_row(field, row) for row in changed), columns)
    require_nonzero(interpreter, [interpreter.expression(row[pivot]) for pivot, row in found.items()])
    return {pivot: _normalised(field_row(field, found[pivot]), pivot) for pivot in sorted(found)}


def _changed(proof: Proof, vector: Row) -> dict[int, Element]:
    """Return a vector in the coordinates (z, x_f)."""
    field = proof.exact.field
    z = {p: dot(field, field_row(field, row), vector) for p, row in proof.flag.rows.items()}
    free = {f: vector[f] for f in proof.kernel.columns if f in vector}
    return {j: entry for j, entry in {**z, **free}.items() if entry}


def _normalised(vector: Row, pivot: int) -> dict[int, Element]:
    return {j: entry / vector[pivot] for j, entry in vector.items()}


def two_parts(proof: Proof) -> tuple[Part, ...]:
    """Return the observable part and N."""
    one = proof.exact.field.one
    observable: Part = {p: {p: one} for p in sorted(proof.flag.rows)}
    return observable, {f: {f: one} for f in proof.kernel.columns}


def four_parts(proof: Proof, reachable: Part) -> tuple[Part, ...]:
    """Divide the reachable subspace in two, and complete it by unit vectors in two parts."""
    seen, hidden = two_parts(proof)
    return (
        {p: vector for p, vector in reachable.items() if p in hidden},
        {p: vector for p, vector in reachable.items() if p in seen},
        {f: vector for f, vector in hidden.items() if f not in reachable},
        {p: vector for p, vector in seen.items() if p not in reachable},
    )


def columns_of(proof: Proof, parts: Sequence[Part]) -> list[Row]:
    """Return the columns of T, by state."""
    field = proof.exact.field
    first = _first_columns(proof)
    vectors = [vector for part in parts for vector in part.values()]
    return [combined(field, ((entry, first[j]) for j, entry in vector.items())) for vector in vectors]


def _first_columns(proof: Proof) -> dict[int, Row]:
    """Return the columns of T_0 by pivot and by free state."""
    field = proof.exact.field
    found: dict[int, Row] = {}
    for p, row in proof.flag.rows.items():
        found[p] = {p: field.one / Element(field, row[p], field.one_polynomial)}
    for f, column in proof.kernel.columns.items():
        found[f] = _normalised(field_row(field, column), f)
    return found


def inverse_rows(proof: Proof, parts: Sequence[Part]) -> list[Row]:
    """Return the rows of T⁻¹ = (1 − E) T_0⁻¹."""
    field = proof.exact.field
    vectors = {pivot: vector for part in parts for pivot, vector in part.items()}
    first: dict[int, Row] = {f: {f: field.one} for f in proof.kernel.columns}
    first |= {p: field_row(field, row) for p, row in proof.flag.rows.items()}
    found: list[Row] = []
    for j in vectors:
        others = [(-vector[j], first[p]) for p, vector in vectors.items() if p != j and j in vector]
        found.append(combined(field, [(field.one, first[j]), *others]))
    return found
