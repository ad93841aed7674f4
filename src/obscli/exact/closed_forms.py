"""Measures of observability in closed form, where every state is observable and M is small.

    b_k = a_k − Σ_l<k (a_k b_l / b_l b_l) b_l   (Gram–Schmidt without roots),   r_k² = b_k b_k
    μ² (c) = 1 / Σ_l (c b_l)² / (b_l b_l μ_l²),   μ_l² = r_l² / r_{l−1}²,     det(MᵀM),     M⁺ = (MᵀM)⁻¹ Mᵀ

Bagmut 2009, (3), (15), (17). Squares are field elements; their roots are taken where they are squares.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import isqrt
from typing import TYPE_CHECKING, Final

from obscli.exact.errors import JetOverflowError, UndecidedError, UndefinedError
from obscli.exact.exact_system import read_system
from obscli.exact.field import Element
from obscli.exact.polynomial import factored
from obscli.exact.restore import Restorer
from obscli.exact.rows import combined, dot
from obscli.exact.tower import Blocks
from obscli.model.expression import Expression, multiply, power


if TYPE_CHECKING:
    from collections.abc import Sequence

    from obscli.exact.exact_system import ExactSystem, Row
    from obscli.exact.polynomial import Polynomial
    from obscli.model.system import Covector, System

#: Larger systems have closed forms that nobody reads.
_MOST_STATES: Final = 6


@dataclass(frozen=True, slots=True, eq=False)
class ClosedForms:
    """Expressions in the parameters, and in time where the system varies; signs are not taken care of.

    Parameters
    ----------
    determinant : det(MᵀM)
    deterministic : μ of every target; None: the target is zero
    pseudo_inverse : of every target the entries of c M⁺, m n of them
    """

    determinant: Expression
    deterministic: tuple[Expression | None, ...]
    pseudo_inverse: tuple[tuple[Expression, ...], ...]


def closed_forms(system: System, targets: Sequence[Covector]) -> ClosedForms | None:
    """Return the closed forms; None where a state is not observable, or the system is too large."""
    if system.n > _MOST_STATES:
        return None
    try:
        return _closed_forms(system, targets)
    except (JetOverflowError, UndecidedError, UndefinedError):
        return None


def _closed_forms(system: System, targets: Sequence[Covector]) -> ClosedForms | None:
    exact = read_system(system, [entry for target in targets for entry in target.values()])
    blocks = Blocks(exact)
    rows = [(output, row) for k in range(system.n) for output, row in enumerate(blocks[k])]
    basis, chain = _orthogonal(exact, rows)
    if len(basis) < system.n:
        return None
    gram = [
        {j: value for j in range(system.n) if (value := _product(exact, rows, i, j))} for i in range(system.n)
    ]
    determinant, solved = _solve(exact, gram, [row for _, row in rows])
    restore = Restorer(exact.interpreter).element
    covectors = [exact.row(target) for target in targets]
    squares = [_squared(exact, covector, basis, chain) for covector in covectors]
    return ClosedForms(
        determinant=restore(determinant),
        deterministic=tuple(None if one is None else _root(exact, one) for one in squares),
        pseudo_inverse=tuple(
            tuple(restore(dot(exact.field, covector, column)) for column in solved) for covector in covectors
        ),
    )


def _product(exact: ExactSystem, rows: Sequence[tuple[int, Row]], i: int, j: int) -> Element:
    """Return (MᵀM)_ij."""
    total = exact.field.zero
    for _, row in rows:
        if i in row and j in row:
            total = total + row[i] * row[j]
    return total


def _orthogonal(exact: ExactSystem, rows: Sequence[tuple[int, Row]]) -> tuple[list[Row], list[Element]]:
    """Return b_k and μ_k² of the rows that are independent of those before them."""
    field = exact.field
    basis: list[Row] = []
    sizes: list[Element] = []
    chain: list[Element] = []
    last: dict[int, Element] = {}
    for output, row in rows:
        parts = [(-(dot(field, row, b) / size), b) for b, size in zip(basis, sizes, strict=True)]
        rest = combined(field, [(field.one, row), *parts])
        if not rest:
            continue
        size = dot(field, rest, rest)
        if not size:
            raise UndecidedError("a sum of squares vanishes")
        basis.append(rest)
        sizes.append(size)
        chain.append(size / last[output] if output in last else size)
        last[output] = size
    return basis, chain


def _squared(
    exact: ExactSystem, covector: Row, basis: Sequence[Row], chain: Sequence[Element]
) -> Element | None:
    """Return μ² of a linear form; None of none."""
    field = exact.field
    total = field.zero
    for b, mu in zip(basis, chain, strict=True):
        along = dot(field, covector, b)
        total = total + along * along / (dot(field, b, b) * mu)
    return field.one / total if total else None


def _solve(
    exact: ExactSystem, gram: Sequence[Row], columns: Sequence[Row]
) -> tuple[Element, list[dict[int, Element]]]:
    """Return det G and G⁻¹ v of columns, G positive definite."""
    field, n = exact.field, len(gram)
    width = n + len(columns)
    work = [
        {**row, **{n + c: column[i] for c, column in enumerate(columns) if i in column}}
        for i, row in enumerate(gram)
    ]
    determinant = field.one
    for k in range(n):
        pivot = work[k].get(k, field.zero)
        if not pivot:
            raise UndecidedError("a leading minor of a Gram matrix vanishes")
        determinant = determinant * pivot
        work[k] = {j: entry / pivot for j, entry in work[k].items()}
        for i in range(n):
            if i != k and k in work[i]:
                work[i] = combined(field, [(field.one, work[i]), (-work[i][k], work[k])])
    return determinant, [{i: work[i][c] for i in range(n) if c in work[i]} for c in range(n, width)]


def _root(exact: ExactSystem, square: Element) -> Expression:
    """Return the root of an element, taken where it is a square."""
    outer, inner = exact.field.one, exact.field.one
    for polynomial, sign in ((square.num, 1), (square.den, -1)):
        out, rest = _parts(exact, polynomial)
        outer = outer * out**sign
        inner = inner * rest**sign
    restore = Restorer(exact.interpreter).element
    whole = restore(outer)
    if inner.rational == 1:
        return whole
    return multiply(whole, power(restore(inner), Fraction(1, 2)))


def _parts(exact: ExactSystem, polynomial: Polynomial) -> tuple[Element, Element]:
    """Return p and q with p² q the polynomial, q without squares."""
    field = exact.field
    content, factors = factored(polynomial)
    root = isqrt(abs(content))
    exactly = root * root == content
    outer = field.rational(root if exactly else 1)
    inner = field.rational(1 if exactly else content)
    for factor, exponent in factors:
        element = Element(field, factor, field.one_polynomial)
        outer = outer * element ** (exponent // 2)
        inner = inner * element ** (exponent % 2)
    return outer, inner
