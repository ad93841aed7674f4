"""The proof that the rank is at least r: a minor of L whose ball at a rational point excludes zero.

    L_0 = H,  L_{k+1} = L_k' + L_k A   as Taylor series in ball arithmetic, straight from the model

Analytic coefficients with one nonzero value of a minor have it nonzero at all but isolated times and on
a dense open set of parameters: rank ≥ r is then generic.
"""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from obscli.exact.ball import BallPoint, OutsideDomainError, precision, random_point
from obscli.exact.determinant import determinant
from obscli.exact.errors import UndecidedError
from obscli.exact.finding import LowerBound
from obscli.model.expression import Derivative, Expression, postorder, symbols


if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from flint import arb, arb_series

    from obscli.exact.interpreter import Interpreter
    from obscli.model.system import Matrix, System

#: Bits of the ball arithmetic, in the order tried.
PRECISIONS = (128, 128, 128, 512, 512, 2000, 4000)
_POINTS = 60


def prove_lower_bound(
    system: System,
    interpreter: Interpreter,
    rows: Sequence[tuple[int, int]],
    columns: Sequence[int],
    *,
    patient: bool = True,
) -> LowerBound:
    """Find a rational point at which the minor of L provably does not vanish.

    Parameters
    ----------
    rows : (order, output index) of each row of the minor
    columns : its columns
    patient : raise the precision before giving up; otherwise a few points must do

    Raises
    ------
    UndecidedError : the ball contains zero at every point and precision tried
    """
    names = used_names(system)
    depth = max((order for order, _ in rows), default=0) + 1 + highest_derivative(system)
    definitions = interpreter.definitions
    bits = iter(PRECISIONS if patient else PRECISIONS[:3])
    current = next(bits)
    for seed in range(_POINTS):
        values = random_point(system, names - definitions.keys(), depth, seed)
        try:
            ball = minor(system, rows, columns, values, current, definitions)
        except OutsideDomainError:
            continue
        if not ball.contains(0):
            return _bound(system, rows, columns, values, ball, current)
        following = next(bits, None)
        if following is None:
            break
        current = following
    raise UndecidedError(
        "no point was found at which the minor that should prove the rank is seen to differ from zero"
    )


def minor(
    system: System,
    rows: Sequence[tuple[int, int]],
    columns: Sequence[int],
    values: Mapping[str, Fraction],
    bits: int,
    definitions: Mapping[str, Expression],
) -> arb:
    """Return the ball of the minor of L with these rows and columns at a point.

    Raises
    ------
    OutsideDomainError : some coefficient does not exist at the point
    """
    order = max((k for k, _ in rows), default=0)
    length = order + 1 + highest_derivative(system)
    with precision(bits, length):
        point = BallPoint(system, values, length, definitions)
        A, H = series_rows(point, system.A), series_rows(point, system.H)
        known: dict[tuple[int, int], dict[int, arb_series]] = {}
        for k, output in sorted({(i, o) for top, o in rows for i in range(top + 1)}):
            known[k, output] = H[output] if k == 0 else differentiated(known[k - 1, output], A)
        place = {column: k for k, column in enumerate(columns)}
        return determinant([{place[j]: e[0] for j, e in known[row].items() if j in place} for row in rows])


def used_names(system: System) -> frozenset[str]:
    """Return the names on which A, H and the rules of the functions in them depend."""
    return names_behind(system, [*system.A.entries.values(), *system.H.entries.values()])


def names_behind(system: System, expressions: Iterable[Expression]) -> frozenset[str]:
    """Return the names in expressions, and in the rules and relations of the functions among them."""
    names = symbols(*expressions)
    while True:
        rules = [f.derivative for f in system.functions if f.derivative is not None and f.name in names]
        relations = [i.expression for i in system.invariants if symbols(i.expression) & names]
        more = names | symbols(*rules, *relations)
        if more == names:
            return names
        names = more


def highest_derivative(system: System) -> int:
    """Return the highest order of ``deriv`` of a function in the matrices."""
    return highest_derivative_of([*system.A.entries.values(), *system.H.entries.values()])


def highest_derivative_of(expressions: Iterable[Expression]) -> int:
    """Return the highest order of ``deriv`` of a function in expressions."""
    nodes = postorder(*expressions)
    return max((node.order for node in nodes if isinstance(node, Derivative)), default=0)


def series_rows(point: BallPoint, matrix: Matrix) -> list[dict[int, arb_series]]:
    """Return the series of the entries of a matrix by rows.

    Raises
    ------
    OutsideDomainError : an entry does not exist at the point
    """
    rows: list[dict[int, arb_series]] = [{} for _ in range(matrix.rows)]
    for (i, j), expression in matrix.entries.items():
        rows[i][j] = point.value(expression)
    return rows


def differentiated(row: dict[int, arb_series], A: list[dict[int, arb_series]]) -> dict[int, arb_series]:
    """Return l' + l A, one term shorter than l where l varies."""
    result = {j: series.derivative() for j, series in row.items()}
    for i, series in row.items():
        for j, entry in A[i].items():
            product = series * entry
            result[j] = result[j] + product if j in result else product
    return result


def _bound(
    system: System,
    rows: Sequence[tuple[int, int]],
    columns: Iterable[int],
    values: Mapping[str, Fraction],
    ball: arb,
    bits: int,
) -> LowerBound:
    with precision(bits, 1):
        midpoint, radius = ball.mid().str(15, radius=False), ball.rad().str(5, radius=False)
    return LowerBound(
        point={name: str(value) for name, value in values.items()},
        rows=tuple((system.outputs[output].name, order) for order, output in rows),
        columns=tuple(system.states[j].name for j in columns),
        midpoint=midpoint,
        radius=radius,
        precision=bits,
    )
