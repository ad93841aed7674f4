"""The reachable subspace: the columns P_k along which inputs move the state; its dimension is proved.

    P_0 = B,   P_{k+1} = A P_k − P_k'

Transposed, up to sign, these are the rows of the observability matrix of the dual system x' = −Aᵀ x,
y = Bᵀ x:  L_0 = Bᵀ, L_{k+1} = L_k' − L_k Aᵀ. So the dual goes through the same saturation, elimination and
bounds, over the field of the system itself.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from obscli.exact.elimination import eliminate, everything
from obscli.exact.errors import UndecidedError, UndefinedError
from obscli.exact.exact_system import ExactSystem
from obscli.exact.field import Element
from obscli.exact.kernel import invariant_kernel, kernel_columns
from obscli.exact.lower import prove_lower_bound
from obscli.exact.nonzero import require_nonzero
from obscli.exact.rows import transpose
from obscli.exact.saturation import saturate
from obscli.model.acting import Inputs
from obscli.model.expression import negate
from obscli.model.system import Matrix, Output, System


if TYPE_CHECKING:
    from obscli.exact.echelon import PolyRow
    from obscli.exact.exact_system import Row


def dual_system(system: System, inputs: Inputs) -> System:
    """Return x' = −Aᵀ x, y = Bᵀ x, with the inputs for outputs."""
    place = system.states[0].place
    return replace(
        system,
        outputs=tuple(Output(name, place) for name in inputs.names),
        A=Matrix(system.n, system.n, {(j, i): negate(e) for (i, j), e in system.A.entries.items()}),
        H=Matrix(inputs.matrix.columns, system.n, {(k, i): e for (i, k), e in inputs.matrix.entries.items()}),
        B=None,
        G=None,
        inputs=(),
        disturbances=(),
    )


def reachable_rows(exact: ExactSystem, inputs: Inputs) -> dict[int, PolyRow]:
    """Return a basis of the reachable subspace in reduced echelon form, pivot state → vector.

    Parameters
    ----------
    exact : a system whose field holds the entries of the input matrix

    Raises
    ------
    UndecidedError : the dimension cannot be decided, or the coefficients grow too large
    JetOverflowError : more derivatives of a function are needed than the field holds
    """
    dual = _dual(exact, inputs)
    saturation = saturate(dual)
    columns = range(exact.n)
    full = saturation.rank == exact.n
    rows = everything(dual).rows if full else eliminate(dual, saturation, columns).rows
    invariant_kernel(dual, kernel_columns(exact.field, rows, columns))
    prove_lower_bound(dual.system, exact.interpreter, saturation.rows, list(rows))
    pivots = [exact.interpreter.expression(row[pivot]) for pivot, row in rows.items()]
    require_nonzero(exact.interpreter, pivots)
    return rows


def input_rows(exact: ExactSystem, inputs: Inputs) -> tuple[Row, ...]:
    """Return the input matrix by rows as elements of the field of a system.

    Raises
    ------
    UndecidedError : an entry does not exist, or zero cannot be decided for it
    """
    rows: list[dict[int, Element]] = [{} for _ in range(exact.n)]
    for (i, k), expression in inputs.matrix.entries.items():
        try:
            element = exact.interpreter.read(expression)
        except UndefinedError:
            reason = f"an entry of {inputs.by} does not exist: the denominator is identically zero"
            raise UndecidedError(reason) from None
        if element:
            rows[i][k] = element
    return tuple(rows)


def _dual(exact: ExactSystem, inputs: Inputs) -> ExactSystem:
    minus = ({j: -entry for j, entry in row.items()} for row in exact.A)
    A, H = transpose(minus, exact.n), transpose(input_rows(exact, inputs), inputs.matrix.columns)
    return ExactSystem(dual_system(exact.system, inputs), exact.interpreter, A, H)
