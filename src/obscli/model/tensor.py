"""Scalars, vectors and matrices of forms, and the arithmetic of them that a file may use.

Shapes: () scalar, (n,) vector, (m, n) matrix; entries by rows. A 1-vector and a 1×1 matrix serve as scalars.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from obscli.model.expression import Expression
from obscli.model.form import (
    ONE_FORM,
    ZERO_FORM,
    Form,
    Impossible,
    exponential,
    is_zero_form,
    opposite,
    product,
    quotient,
    total,
)


MOST_ENTRIES: Final = 250_000


@dataclass(frozen=True, slots=True, eq=False)
class Tensor:
    """Forms in a shape."""

    shape: tuple[int, ...]
    entries: tuple[Form, ...]

    def row(self, i: int) -> tuple[Form, ...]:
        """Return row i (from 0) of a matrix."""
        n = self.shape[1]
        return self.entries[i * n : (i + 1) * n]

    @property
    def is_scalar(self) -> bool:
        """Whether there is exactly one entry."""
        return len(self.entries) == 1

    @property
    def weight(self) -> int:
        """How much work one pass over the entries is."""
        return sum(1 + len(entry.linear) for entry in self.entries)


def scalar(value: Form | Expression) -> Tensor:
    """Return the value as a tensor without dimensions."""
    return Tensor((), (value if isinstance(value, Form) else Form(value),))


def vector(entries: tuple[Form, ...]) -> Tensor:
    """Return the entries as a vector."""
    return Tensor((len(entries),), entries)


def matrix(rows: int, columns: int, entry: Callable[[int, int], Form]) -> Tensor:
    """Return the matrix with these entries (indices from 0)."""
    if rows * columns > MOST_ENTRIES:
        raise Impossible(f"a matrix of {rows} × {columns} is too large")
    return Tensor((rows, columns), tuple(entry(i, j) for i in range(rows) for j in range(columns)))


def named(shape: tuple[int, ...]) -> str:
    """Return the shape in words."""
    match shape:
        case ():
            return "a scalar"
        case (n,):
            return f"a vector of {n}"
    return "a " + "×".join(str(n) for n in shape) + " matrix"


def stack(parts: tuple[Tensor, ...]) -> Tensor:
    """Return the list of scalars as a vector, the list of vectors as the rows of a matrix."""
    if not parts:
        raise Impossible("an empty list is no vector")
    shapes = {part.shape for part in parts}
    if len(shapes) > 1:
        found = " and ".join(sorted(named(shape) for shape in shapes)[:3])
        hint = "quote an expression that contains commas: YAML splits lists at commas"
        raise Impossible(f"the rows of this list differ in length: {found}", hint)
    (shape,) = shapes
    if len(shape) > 1:
        raise Impossible("lists are nested over two deep; a matrix is a list of rows", "use block([[...]])")
    if len(parts) * sum(shape or (1,)) > MOST_ENTRIES:
        raise Impossible("this matrix is too large")
    return Tensor((len(parts), *shape), tuple(entry for part in parts for entry in part.entries))


def plus(left: Tensor, right: Tensor, sign: str = "+") -> Tensor:
    """Return left ± right, entry by entry."""
    if left.is_scalar and right.is_scalar:
        left, right = scalar(left.entries[0]), scalar(right.entries[0])
    if left.shape != right.shape:
        raise Impossible(f"{named(left.shape)} {sign} {named(right.shape)}: the shapes differ")
    second = right.entries if sign == "+" else tuple(opposite(entry) for entry in right.entries)
    return Tensor(left.shape, tuple(total(pair) for pair in zip(left.entries, second, strict=True)))


def minus(value: Tensor) -> Tensor:
    """Return −value."""
    return Tensor(value.shape, tuple(opposite(entry) for entry in value.entries))


def times(left: Tensor, right: Tensor) -> Tensor:
    """Return the product where one of the two is a scalar."""
    if not left.is_scalar and not right.is_scalar:
        hint = "write '@' for the product of matrices, dot(a, b) or cross(a, b) of vectors"
        raise Impossible(f"{named(left.shape)} * {named(right.shape)}: '*' takes a scalar on one side", hint)
    if right.is_scalar:
        factor = right.entries[0]
        return Tensor(left.shape, tuple(product(entry, factor) for entry in left.entries))
    factor = left.entries[0]
    return Tensor(right.shape, tuple(product(factor, entry) for entry in right.entries))


def over(left: Tensor, right: Tensor) -> Tensor:
    """Return left / scalar."""
    if not right.is_scalar:
        raise Impossible(f"division by {named(right.shape)}")
    return Tensor(left.shape, tuple(quotient(entry, right.entries[0]) for entry in left.entries))


def to_the(left: Tensor, right: Tensor) -> Tensor:
    """Return scalar ^ scalar."""
    if not (left.is_scalar and right.is_scalar):
        hint = "write M @ M for the square of a matrix, dot(v, v) for that of a vector"
        raise Impossible(f"{named(left.shape)} ^ {named(right.shape)}: powers are of scalars", hint)
    return scalar(exponential(left.entries[0], right.entries[0]))


def inner(left: tuple[Form, ...], right: tuple[Form, ...]) -> Form:
    """Return Σ left·right; zeros cost nothing."""
    pairs = zip(left, right, strict=True)
    return total([product(a, b) for a, b in pairs if not (is_zero_form(a) or is_zero_form(b))])


def matmul(left: Tensor, right: Tensor) -> Tensor:
    """Return left @ right: matrices and vectors, a vector on the right is a column."""
    match left.shape, right.shape:
        case (m, n), (k,) if n == k:
            return vector(tuple(inner(left.row(i), right.entries) for i in range(m)))
        case (m, n), (k, p) if n == k:
            columns = [right.entries[j::p] for j in range(p)]
            return matrix(m, p, lambda i, j: inner(left.row(i), columns[j]))
        case (n,), (k,) if n == k:
            return scalar(inner(left.entries, right.entries))
        case (n,), (k, p) if n == k:
            return vector(tuple(inner(left.entries, right.entries[j::p]) for j in range(p)))
        case (n,), (1, p):
            return matrix(n, p, lambda i, j: product(left.entries[i], right.entries[j]))
    hint = "" if left.shape and right.shape else "write '*' for the product with a scalar"
    raise Impossible(f"{named(left.shape)} @ {named(right.shape)}: the shapes do not fit", hint)


def transpose(value: Tensor) -> Tensor:
    """Return the transpose; that of a vector is a row."""
    if len(value.shape) == 1:
        return Tensor((1, *value.shape), value.entries)
    if not value.shape:
        return value
    m, n = value.shape
    return matrix(n, m, lambda i, j: value.entries[j * n + i])


def index(value: Tensor, positions: tuple[int, ...]) -> Tensor:
    """Return the entry at positions counted from 1."""
    if len(positions) != len(value.shape) or not positions:
        wanted = {0: "no index", 1: "one index, v[i]", 2: "two, M[i,j]"}[len(value.shape)]
        raise Impossible(f"{named(value.shape)} takes {wanted}")
    for position, size in zip(positions, value.shape, strict=True):
        if not 1 <= position <= size:
            raise Impossible(f"index {position} is outside 1 to {size}")
    at = 0
    for position, size in zip(positions, value.shape, strict=True):
        at = at * size + position - 1
    return scalar(value.entries[at])


def identity(n: int) -> Tensor:
    """Return the n × n identity."""
    return matrix(n, n, lambda i, j: ONE_FORM if i == j else ZERO_FORM)
