"""A system in new variables z = S x, as many as there are observable combinations, or as there are states.

    z' = Ã z + B̃ u + G̃ w,   y = H̃ z     with     Ã S = S' + S A,   H̃ S = H,   B̃ = S B,   G̃ = S G

exists exactly where the rows of S span S' + S A and H: the observable combinations do. With the reduced
echelon form of S, pivots p and free states f, the states are x = R z + N w for any w,

    x_p = Σ_k R_pk z_k + Σ_f N_pf x_f,   R_f = 0,     so     Ã = (S' + S A) R,   H̃ = H R

(Theory of the minimal realisation: Kalman 1963; for A(t) Silverman & Meadows 1967.)
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from obscli.exact.echelon import polynomial_row, reduced_echelon
from obscli.exact.errors import JetOverflowError, UndecidedError
from obscli.exact.exact_system import ExactSystem, more_jets, read_system
from obscli.exact.field import Element
from obscli.exact.restore import Restorer
from obscli.exact.rows import combined, field_row, rate_of
from obscli.model.expression import Apply, Expression, Number, Pi, Power, Product, Sum, divide
from obscli.model.notation import to_text
from obscli.model.system import Covector, Matrix, Quantity, System


if TYPE_CHECKING:
    from collections.abc import Sequence

    from obscli.exact.exact_system import Row
    from obscli.exact.polynomial import Polynomial

#: A matrix of expressions by sparse rows.
Rows: TypeAlias = "tuple[dict[int, Expression], ...]"


@dataclass(frozen=True, slots=True, eq=False)
class StateBack:
    """A state in the new variables (by place) and the free states, whatever their value."""

    variables: Mapping[int, Expression]
    free: Covector


@dataclass(frozen=True, slots=True, eq=False)
class Coordinates:
    """A system in the variables z = S x.

    Parameters
    ----------
    system : the system in x
    forms : S by rows
    A, H : Ã (r, r) and H̃ (m, r) by sparse rows
    B, G : B̃ and G̃; None where the system has none
    back : the states that are pivots of S, in the new variables; the others are free
    quantities : quantities of the system that are combinations of the new variables, by place of these
    divides_by : factors of the denominators in Ã, H̃, B̃, G̃, but those that the file says are not zero
    """

    system: System
    forms: tuple[Covector, ...]
    A: Rows
    H: Rows
    B: Rows | None
    G: Rows | None
    back: Mapping[str, StateBack]
    quantities: tuple[tuple[Quantity, Mapping[int, Expression]], ...]
    divides_by: tuple[Expression, ...]


def in_variables(system: System, forms: Sequence[Covector], columns: Sequence[int]) -> Coordinates:
    """Return a system in variables whose span is closed: the observable combinations, or a basis of all.

    Parameters
    ----------
    forms : S by rows, independent
    columns : order of the states in which pivots are sought

    Raises
    ------
    UndecidedError : the forms depend on each other, or the coefficients are too large
    """
    extra = [e for form in forms for e in form.values()]
    extra += [e for quantity in system.quantities for e in quantity.coefficients.values()]
    extra += [e for matrix in (system.B, system.G) if matrix for e in matrix.entries.values()]
    exact = read_system(system, extra)
    while True:
        try:
            return _Reduction(exact, forms, columns).coordinates()
        except JetOverflowError:
            exact = more_jets(exact, extra)


class _Reduction:
    def __init__(self, exact: ExactSystem, forms: Sequence[Covector], columns: Sequence[int]) -> None:
        self.exact, self.field = exact, exact.field
        self.forms = tuple(forms)
        self.S = [exact.row(form) for form in forms]
        self.restorer = Restorer(exact.interpreter)
        self.divisors: dict[str, Polynomial] = {}
        self.R, self.N = self._right_inverse(columns)

    def _right_inverse(self, columns: Sequence[int]) -> tuple[dict[int, Row], dict[int, Row]]:
        """Return R and N by pivot state, from the reduced echelon form of [S | 1]."""
        n, one = self.exact.n, self.field.one
        rows = [polynomial_row(self.field, {**row, n + k: one}) for k, row in enumerate(self.S)]
        order = [*columns, *range(n, n + len(rows))]
        R: dict[int, Row] = {}
        N: dict[int, Row] = {}
        for pivot, row in reduced_echelon(self.field, rows, order).items():
            if pivot >= n:
                raise UndecidedError("the new variables depend on each other")
            entries = field_row(self.field, row)
            lead = entries.pop(pivot)
            R[pivot] = {j - n: entry / lead for j, entry in entries.items() if j >= n}
            N[pivot] = {j: -entry / lead for j, entry in entries.items() if j < n}
        return R, N

    def coordinates(self) -> Coordinates:
        """Return everything in the new variables."""
        system, exact = self.exact.system, self.exact
        A = self._equations(self._in_z(rate_of(exact, row)) for row in self.S)
        H = self._equations(self._in_z(row) for row in exact.H)
        B, G = (None if one is None else self._equations(self._driven(one)) for one in (system.B, system.G))
        names = system.state_names
        return Coordinates(
            system=system,
            forms=self.forms,
            A=A,
            H=H,
            B=B,
            G=G,
            back={names[p]: StateBack(self._written(self.R[p]), self._free(p)) for p in sorted(self.R)},
            quantities=tuple(self._quantities()),
            divides_by=tuple(self._divides_by()),
        )

    def _in_z(self, row: Row) -> dict[int, Element]:
        """Return a row of the span of S as a combination of its rows."""
        return combined(self.field, ((entry, self.R[p]) for p, entry in row.items() if p in self.R))

    def _driven(self, matrix: Matrix) -> Iterator[Row]:
        """Yield the rows of S B."""
        rows: list[dict[int, Element]] = [{} for _ in range(self.exact.n)]
        for (i, k), expression in matrix.entries.items():
            rows[i][k] = self.exact.interpreter.read(expression)
        for row in self.S:
            yield combined(self.field, ((entry, rows[j]) for j, entry in row.items()))

    def _quantities(self) -> list[tuple[Quantity, Mapping[int, Expression]]]:
        found: list[tuple[Quantity, Mapping[int, Expression]]] = []
        for quantity in self.exact.system.quantities:
            row = self.exact.row(quantity.coefficients)
            z = self._in_z(row)
            rest = combined(self.field, [(self.field.one, row), *((-e, self.S[k]) for k, e in z.items())])
            if z and not rest:
                found.append((quantity, self._written(z)))
        return found

    def _equations(self, rows: Iterable[Row]) -> Rows:
        """Return rows as expressions, and remember what they divide by."""
        found = tuple(rows)
        for row in found:
            self.divisors.update({str(entry.den): entry.den for entry in row.values()})
        return tuple(self._written(row) for row in found)

    def _written(self, row: Row) -> dict[int, Expression]:
        return {j: written(self.restorer, row[j]) for j in sorted(row)}

    def _free(self, pivot: int) -> Covector:
        names = self.exact.system.state_names
        return {names[j]: entry for j, entry in self._written(self.N[pivot]).items()}

    def _divides_by(self) -> list[Expression]:
        """Return the factors of the divisors that may vanish, each once."""
        nonzero = {one.name for one in self.exact.system.parameters if one.assume != "real"}
        found: dict[str, Expression] = {}
        for divisor in self.divisors.values():
            for factor in factors_of(self.restorer.polynomial(divisor)):
                text = to_text(factor)
                if text not in nonzero:
                    found.setdefault(text, factor)
        return list(found.values())


def written(restorer: Restorer, element: Element) -> Expression:
    """Return an element as an expression, without a minus below the line."""
    above, below = restorer.row_unscaled([element.num, element.den])
    if is_negative(below):
        above, below = restorer.row_unscaled([-element.num, -element.den])
    return divide(above, below)


def is_negative(expression: Expression) -> bool:
    """Whether an expression begins with a minus."""
    match expression:
        case Number(value):
            return value < 0
        case Product(parts) | Sum(parts):
            return is_negative(parts[0])
    return False


def factors_of(expression: Expression) -> Iterator[Expression]:
    """Yield the factors of an expression as written that may vanish."""
    match expression:
        case Product(factors):
            for factor in factors:
                yield from factors_of(factor)
        case Power(base):
            yield from factors_of(base)
        case Number() | Pi() | Apply("exp"):
            return
        case _:
            yield expression
