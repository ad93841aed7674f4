"""The characteristic polynomial of a constant matrix over the field, in irreducible factors, and their modes.

Faddeev–LeVerrier:   M_1 = A,  c_{d-k} = −tr(M_k)/k,  M_{k+1} = A (M_k + c_{d-k} I)

    det(s I − A) = s^d + c_{d-1} s^{d-1} + … + c_0 = Π_i q_i(s)^{m_i}

The modes of a factor are ker q(A); where that is smaller than m deg q the rest of ker q(A)^m is *chained*:
it moves into ker q(A), by a power of time more.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from flint import Ordering, fmpz_mpoly_ctx

from obscli.exact.echelon import polynomial_row, reduced_echelon
from obscli.exact.field import Element, common_denominator
from obscli.exact.kernel import kernel_columns
from obscli.exact.polynomial import factored, polynomial_coefficients, require_small, times
from obscli.exact.rows import field_row


if TYPE_CHECKING:
    from collections.abc import Sequence

    from obscli.exact.exact_system import Row
    from obscli.exact.field import Field
    from obscli.exact.polynomial import Polynomial

#: A square matrix over the field as sparse rows.
Square: TypeAlias = "tuple[Row, ...]"

#: Larger matrices than this would take long.
_LARGEST = 200


@dataclass(frozen=True, slots=True, eq=False)
class Factor:
    """An irreducible factor q(s) = Σ q_k s^k of a characteristic polynomial, monic, and its multiplicity."""

    coefficients: tuple[Element, ...]
    multiplicity: int

    @property
    def degree(self) -> int:
        """The degree of q."""
        return len(self.coefficients) - 1


def characteristic_polynomial(field: Field, matrix: Square) -> list[Element]:
    """Return the coefficients of det(s I − A), by rising degree.

    Raises
    ------
    UndecidedError : the matrix or its coefficients are too large
    """
    d = len(matrix)
    require_small(d, _LARGEST)
    coefficients = [field.one]
    power = matrix
    for k in range(1, d + 1):
        trace = field.zero
        for i, row in enumerate(power):
            trace = trace + row.get(i, field.zero)
        coefficient = -trace / field.rational(k)
        coefficients.append(coefficient)
        if k < d:
            power = product(field, matrix, _plus_multiple(field, power, coefficient))
    return coefficients[::-1]


def product(field: Field, left: Square, right: Square) -> Square:
    """Return the product of two square matrices."""
    result = []
    for row in left:
        total: dict[int, Element] = {}
        for k, entry in row.items():
            for j, other in right[k].items():
                total[j] = total.get(j, field.zero) + entry * other
        result.append({j: entry for j, entry in total.items() if entry})
    return tuple(result)


def _plus_multiple(field: Field, matrix: Square, multiple: Element) -> Square:
    """Return A + c I."""
    if not multiple:
        return matrix
    rows = [{**row, i: row.get(i, field.zero) + multiple} for i, row in enumerate(matrix)]
    return tuple({j: entry for j, entry in row.items() if entry} for row in rows)


def factors(field: Field, coefficients: Sequence[Element], *, formally: bool = False) -> list[Factor]:
    """Return the irreducible factors of a monic polynomial in s over the field, by degree.

    Where algebraic generators occur in it, only powers of s and perfect splittings by them are left
    unfound: the polynomial then counts as one factor. ``formally``: they are taken for independent; the
    factors found then divide it all the same, but they may have roots in common.
    """
    degree = next(k for k, c in enumerate(coefficients) if c)
    found = [Factor((field.zero, field.one), degree)] if degree else []
    rest = coefficients[degree:]
    if len(rest) == 1:
        return found
    if len(rest) == 2 or (_is_algebraic(field, rest) and not formally):
        return [*found, Factor(tuple(rest), 1)]
    return [*found, *_factored(field, rest)]


def _is_algebraic(field: Field, coefficients: Sequence[Element]) -> bool:
    roots = [index for index, _ in field.relations]
    return any(c.num.degrees()[k] > 0 or c.den.degrees()[k] > 0 for c in coefficients for k in roots)


def _factored(field: Field, coefficients: Sequence[Element]) -> list[Factor]:
    """Factor over Z[generators, s]."""
    names = [f"v{k}" for k in range(field.ctx.nvars())]
    ring = fmpz_mpoly_ctx.get([*names, "s"], Ordering.lex)
    den = common_denominator(coefficients, field.one_polynomial)
    terms = {}
    for k, c in enumerate(coefficients):
        for exponents, number in times(c.num, den / c.den).terms():
            terms[*exponents, k] = number
    found = []
    for factor, multiplicity in factored(ring.from_dict(terms))[1]:
        if factor.degrees()[-1] > 0:
            parts = [_back(field, part) for part in polynomial_coefficients(factor, len(names))]
            found.append(Factor(tuple(part / parts[-1] for part in parts), multiplicity))
    return sorted(found, key=lambda factor: factor.degree)


def _back(field: Field, polynomial: Polynomial) -> Element:
    terms = {tuple(exponents[:-1]): number for exponents, number in polynomial.terms()}
    return Element(field, field.ctx.from_dict(terms), field.one_polynomial)


def modes_of(field: Field, matrix: Square, factor: Factor) -> tuple[list[Row], list[Row]]:
    """Return a basis of ker q(A), and what completes it to a basis of ker q(A)^m."""
    value = _value(field, matrix, factor.coefficients)
    proper = _kernel(field, value)
    if len(proper) == factor.degree * factor.multiplicity:
        return proper, []
    power = value
    for _ in range(factor.multiplicity - 1):
        power = product(field, value, power)
    return proper, _completing(field, proper, _kernel(field, power), len(matrix))


def _value(field: Field, matrix: Square, coefficients: Sequence[Element]) -> Square:
    """Return q(A), by Horner's rule."""
    total: Square = tuple({i: coefficients[-1]} for i in range(len(matrix)))
    for coefficient in reversed(coefficients[:-1]):
        total = _plus_multiple(field, product(field, matrix, total), coefficient)
    return total


def _kernel(field: Field, matrix: Square) -> list[Row]:
    columns = range(len(matrix))
    echelon = reduced_echelon(field, [polynomial_row(field, row) for row in matrix if row], columns)
    return [field_row(field, column) for column in kernel_columns(field, echelon, columns).values()]


def _completing(field: Field, known: Sequence[Row], all_of_them: Sequence[Row], size: int) -> list[Row]:
    rows = [polynomial_row(field, row) for row in known]
    found = []
    for candidate in all_of_them:
        more = [*rows, polynomial_row(field, candidate)]
        if len(reduced_echelon(field, more, range(size))) == len(more):
            rows = more
            found.append(candidate)
    return found
