"""Vectors of the null space of A − λ I, to half of the digits in force.

A simple eigenvalue has one, found by inverse iteration

    (A − (λ + δ) I) v⁺ = v,   δ = ‖A‖ 2^(−bits/2),

which makes whatever else v holds smaller by δ over the gap to the next eigenvalue, each time. Where λ occurs
more often elimination with full pivoting tells how many there are: pivots below ‖A‖ 2^(−bits/2) are zero.

References
----------
G. H. Golub, C. F. Van Loan, Matrix Computations, 7.6.1, 3.4.8.
"""

from __future__ import annotations

from typing import Final

from flint import acb, acb_mat, arb, ctx

from obscli.measures.mode_values import ModeValue, largest


_MOST_ITERATIONS: Final = 6


class UnresolvedModeError(ArithmeticError):
    """The vectors of an eigenvalue are not told apart at the precision in force."""


def half_precision() -> arb:
    """Return 2^(−bits/2): what is smaller, relatively, is rounding."""
    return arb(2) ** -(ctx.prec // 2)


def mode_vectors(A: acb_mat, mode: ModeValue) -> acb_mat:
    """Return a basis of the vectors of an eigenvalue, columns; use inside ``precision``.

    Raises
    ------
    UnresolvedModeError
        where more digits are needed
    """
    if mode.count == 1:
        return _vector(A, mode.value)
    vectors = _null_space(A, mode.value)
    if not vectors.ncols():  # the mean of eigenvalues that are near each other, and not the same
        raise UnresolvedModeError
    return vectors


def _vector(A: acb_mat, value: acb) -> acb_mat:
    """Return the vector of a simple eigenvalue, its largest component 1."""
    n = A.nrows()
    size = largest(A)
    shift = value + (size if size > 0 else arb(1)) * half_precision()
    shifted = A - shift * _identity(n)
    vector = acb_mat(n, 1, [acb(1) / (k + 3) for k in range(n)])
    for _ in range(_MOST_ITERATIONS):
        before, vector = vector, _unit(shifted.solve(vector, algorithm="approx").mid())
        if largest(vector - before) ** 2 <= half_precision():  # what was left of the rest is squared now
            return vector
    raise UnresolvedModeError


def _identity(n: int) -> acb_mat:
    return acb_mat(n, n, [acb(1 if i == j else 0) for i in range(n) for j in range(n)])


def _unit(vector: acb_mat) -> acb_mat:
    pivot = max(vector.entries(), key=lambda entry: abs(entry).mid())
    return (vector * (1 / pivot)).mid()


def _null_space(A: acb_mat, value: acb) -> acb_mat:
    """Return a basis of the vectors v with A v = λ v, columns, by elimination with full pivoting."""
    n = A.nrows()
    rows = (A - value * _identity(n)).mid().tolist()
    order, rank = list(range(n)), 0
    size = largest(A)
    while rank < n:
        pivot, i, j = max(
            ((abs(rows[i][order[j]]).mid(), i, j) for i in range(rank, n) for j in range(rank, n)),
            key=lambda one: one[0],
        )
        if not pivot > size * half_precision():
            break
        rows[rank], rows[i] = rows[i], rows[rank]
        order[rank], order[j] = order[j], order[rank]
        _eliminate(rows, rank, order[rank])
        rank += 1
    free = order[rank:]
    basis = acb_mat(n, len(free))
    for c, j in enumerate(free):
        basis[j, c] = acb(1)
        for k in range(rank):
            basis[order[k], c] = -rows[k][j]
    return basis


def _eliminate(rows: list[list[acb]], pivot: int, column: int) -> None:
    """Make a column that of the identity."""
    head = rows[pivot][column]
    rows[pivot] = [(entry / head).mid() for entry in rows[pivot]]
    for k, row in enumerate(rows):
        if k != pivot and row[column] != 0:
            factor = row[column]
            rows[k] = [(a - factor * b).mid() for a, b in zip(row, rows[pivot], strict=True)]
