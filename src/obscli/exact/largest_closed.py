"""The largest closed space of forms within given functions times states, and the modes of D on it.

    P_0 = functions ⊗ states,   P_{k+1} = {v ∈ P_k : D v ∈ P_k},        D v = v' + v A

On the last of them, with basis b and D b_i = Σ_j M_ij b_j, the modes are the kernels of q(Mᵀ)^k, q the
irreducible factors of the characteristic polynomial of M: the product of those of the blocks of forms that
lead to each other.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from obscli.exact.echelon import Echelon, polynomial_row, reduced_echelon
from obscli.exact.rows import combined, field_row, transpose
from obscli.exact.spectrum import Factor, characteristic_polynomial, factors, modes_of


if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from obscli.exact.constant_span import Forms
    from obscli.exact.exact_system import Row
    from obscli.exact.field import Field
    from obscli.exact.mode import Mode


def largest_closed(forms: Forms, functions: Sequence[Mode]) -> list[Row]:
    """Return a basis of the largest closed space within functions ⊗ states."""
    field = forms.field
    basis: list[Row] = [{forms.column(i, mode): field.one} for mode in functions for i in range(len(forms.A))]
    while True:
        relations = _relations(forms, basis)
        if len(relations) == len(basis):
            return basis
        basis = [combined(field, [(c, basis[k]) for k, c in row.items()]) for row in relations]


def _relations(forms: Forms, basis: Sequence[Row]) -> list[Row]:
    """Return the c with D Σ c_k b_k in the span of the b_k."""
    field = forms.field
    rates = [forms.rate(row) for row in basis]
    size = len(forms.columns)
    echelon = Echelon(field, range(size + len(basis)))
    for row in basis:
        echelon.insert(echelon.strip(echelon.reduce(polynomial_row(field, row))))
    known = set(echelon.rows)
    outside = [
        echelon.reduce(polynomial_row(field, {**rate, size + k: field.one})) for k, rate in enumerate(rates)
    ]
    columns = [k for k in range(size + len(basis)) if k not in known]
    found = reduced_echelon(field, outside, columns)
    return [
        {k - size: entry for k, entry in field_row(field, row).items()}
        for pivot, row in found.items()
        if pivot >= size
    ]


def modes_of_rate(forms: Forms, basis: Sequence[Row]) -> Iterator[Row]:
    """Yield a basis of a closed space by the modes of D on it, those of low order first."""
    field = forms.field
    matrix = _matrix(forms, basis)
    columns = transpose(matrix, len(basis))
    for factor in _factors(field, matrix):
        for group in modes_of(field, columns, factor):
            for mode in group:
                yield combined(field, [(c, basis[k]) for k, c in mode.items()])


def _factors(field: Field, matrix: Sequence[Row]) -> list[Factor]:
    """Return the factors of the characteristic polynomial, from its blocks."""
    found: dict[str, Factor] = {}
    for block in _blocks(matrix):
        place = {k: position for position, k in enumerate(block)}
        inside = tuple({place[j]: e for j, e in matrix[k].items() if j in place} for k in block)
        for factor in factors(field, characteristic_polynomial(field, inside)):
            key = " ".join(f"({c.num})/({c.den})" for c in factor.coefficients)
            before = found[key].multiplicity if key in found else 0
            found[key] = Factor(factor.coefficients, before + factor.multiplicity)
    return sorted(found.values(), key=lambda factor: factor.degree)


def _blocks(matrix: Sequence[Row]) -> list[list[int]]:
    """Return the sets of indices that lead to each other."""
    leads = [_led_to(matrix, k) for k in range(len(matrix))]
    blocks = {tuple(sorted({k, *(j for j in leads[k] if k in leads[j])})) for k in range(len(matrix))}
    return [list(block) for block in sorted(blocks)]


def _led_to(matrix: Sequence[Row], k: int) -> set[int]:
    found, waiting = set[int](), [k]
    while waiting:
        fresh = set(matrix[waiting.pop()]) - found
        found |= fresh
        waiting += fresh
    return found


def _matrix(forms: Forms, basis: Sequence[Row]) -> list[Row]:
    """Return M with D b_i = Σ_j M_ij b_j."""
    field, size, d = forms.field, len(forms.columns), len(basis)
    rows = [polynomial_row(field, {**row, size + k: field.one}) for k, row in enumerate(basis)]
    echelon = reduced_echelon(field, rows, range(size + d))
    inverse = {p: field_row(field, row) for p, row in echelon.items()}
    result: list[Row] = []
    for row in basis:
        rate = forms.rate(row)
        terms = [(rate[p] / inverse[p][p], inverse[p]) for p in rate if p in inverse]
        total = combined(field, terms)
        result.append({k - size: entry for k, entry in total.items() if k >= size})
    return result
