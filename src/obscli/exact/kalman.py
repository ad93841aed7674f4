"""The structural decomposition of a system by what its outputs see and what its inputs reach.

    x = T x̄,   T = [T_1 basis of Rr ∩ N | T_2 completes Rr | T_3 completes N | T_4 the rest]

    Ā = T⁻¹ (A T − T'),   B̄ = T⁻¹ B,   H̄ = H T

    A_21 = A_23 = A_31 = A_32 = A_41 = A_42 = A_43 = 0,   B_3 = B_4 = 0,   H_1 = H_3 = 0

N are the directions that no output shows, Rr those that inputs reach. Without inputs there are two parts, N
last: A_12 = 0, H_2 = 0, and A_22 is A on N.

Kortunov & Proskura 2006, (9)–(11), there for constant A; over the differential field it holds for A(t) as
it is.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeAlias

from obscli.exact.echelon import polynomial_row
from obscli.exact.errors import JetOverflowError, UndecidedError, UndefinedError
from obscli.exact.kalman_parts import columns_of, four_parts, inverse_rows, reach, two_parts
from obscli.exact.missing import MissingError, RefineError
from obscli.exact.prove import Proof, prove
from obscli.exact.reachable import input_rows
from obscli.exact.rows import combined, drift, transpose
from obscli.model.acting import InputMatrix, Inputs, inputs_of
from obscli.model.system import Covector, System


if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from obscli.exact.exact_system import ExactSystem, Row
    from obscli.exact.kalman_parts import Part
    from obscli.model.expression import Expression


#: How many states are reachable and unobservable, reachable and observable, unobservable, observable only.
Dimensions: TypeAlias = tuple[int, int, int, int]

#: A matrix of expressions by sparse rows.
Rows: TypeAlias = "tuple[dict[int, Expression], ...]"

#: The blocks that are zero, by the places of their parts: of Ā, of H̄ (columns), of B̄ (rows).
_A_ZEROS: Final = frozenset({(1, 0), (1, 2), (2, 0), (2, 1), (3, 0), (3, 1), (3, 2)})
_H_ZEROS: Final = frozenset({0, 2})
_B_ZEROS: Final = frozenset({2, 3})
_A_ZEROS_OF_TWO: Final = frozenset({(0, 1)})
_H_ZEROS_OF_TWO: Final = frozenset({1})


@dataclass(frozen=True, slots=True, eq=False)
class Kalman:
    """x = T x̄ with the structural zeros of Ā, B̄, H̄ verified.

    Parameters
    ----------
    proof : of the system decomposed; its field holds everything
    by : the matrix the reachable subspace is of; None: the two parts without inputs
    sizes : of the four parts (reachable unobservable, reachable observable, unobservable only, observable
        only), without inputs of the two (observable, unobservable)
    variables : x̄_i as a linear form in x, a row of T⁻¹
    columns : columns of T, by state
    A, H : Ā (n, n) and H̄ (m, n)
    B : B̄ (n, p); None without inputs
    """

    proof: Proof
    by: InputMatrix | None
    sizes: tuple[int, ...]
    variables: tuple[Covector, ...]
    columns: tuple[Covector, ...]
    A: Rows
    H: Rows
    B: Rows | None

    @property
    def parts(self) -> tuple[range, ...]:
        """The places of the variables of each part."""
        starts = [sum(self.sizes[:k]) for k in range(len(self.sizes))]
        return tuple(range(start, start + size) for start, size in zip(starts, self.sizes, strict=True))

    @property
    def dimensions(self) -> Dimensions | None:
        """The dimensions of the four parts; None without inputs."""
        if self.by is None:
            return None
        a, b, c, d = self.sizes
        return a, b, c, d


def kalman_dimensions(proof: Proof) -> Dimensions | None:
    """Return the dimensions of the four parts, proved; None where the system has neither B nor G.

    Raises
    ------
    UndecidedError : the reachable subspace cannot be decided
    JetOverflowError : more derivatives of a function are needed than the field of the proof holds
    """
    inputs = inputs_of(proof.exact.system)
    if inputs is None:
        return None
    proof = _with_inputs(proof, inputs)
    a, b, c, d = map(len, four_parts(proof, reach(proof, inputs)))
    return a, b, c, d


def kalman_decomposition(proof: Proof) -> Kalman:
    """Return the decomposition by B, where there is none by G, where there is neither in two parts.

    Raises
    ------
    UndecidedError : the reachable subspace cannot be decided, or a structural zero is not verified
    JetOverflowError : more derivatives of a function are needed than the field of the proof holds
    """
    inputs = inputs_of(proof.exact.system)
    if inputs is None:
        return _decomposed(proof, None, two_parts(proof))
    proof = _with_inputs(proof, inputs)
    return _decomposed(proof, inputs, four_parts(proof, reach(proof, inputs)))


def decompose(system: System, columns: Sequence[int]) -> Kalman:
    """Prove the rank of a system and return its decomposition; ``columns``: order in which pivots are sought.

    Raises
    ------
    UndecidedError : the rank or the reachable subspace cannot be decided, or a zero is not verified
    UndefinedError : a coefficient does not exist
    """
    inputs, jets = inputs_of(system), 4
    extra = () if inputs is None else tuple(inputs.matrix.entries.values())
    while True:
        proof = prove(system, columns, extra, jets)
        try:
            return kalman_decomposition(proof)
        except JetOverflowError:
            jets = 2 * proof.exact.interpreter.jets


def _with_inputs(proof: Proof, inputs: Inputs) -> Proof:
    """Return a proof whose field holds the input matrix."""
    system, interpreter = proof.exact.system, proof.exact.interpreter
    try:
        input_rows(proof.exact, inputs)
    except (MissingError, RefineError, UndecidedError):
        pass
    else:
        return proof
    try:
        return prove(system, range(system.n), inputs.matrix.entries.values(), interpreter.jets)
    except UndefinedError as error:
        raise UndecidedError(f"an entry of {inputs.by} does not exist: {error}") from error


def _decomposed(proof: Proof, inputs: Inputs | None, parts: Sequence[Part]) -> Kalman:
    exact, names = proof.exact, proof.exact.system.state_names
    inverse, columns, variables = _as_printed(proof, inverse_rows(proof, parts), columns_of(proof, parts))
    T = transpose(columns, exact.n)
    A, H = _product(exact, inverse, _moved(exact, columns)), _product(exact, exact.H, T)
    B = None if inputs is None else _product(exact, inverse, input_rows(exact, inputs))
    sizes = tuple(map(len, parts))
    _require_inverse(exact, inverse, T)
    _require_zeros(sizes, A, H, B)
    restored = proof.restorer.element
    return Kalman(
        proof=proof,
        by=None if inputs is None else inputs.by,
        sizes=sizes,
        variables=tuple(variables),
        columns=tuple({names[i]: restored(column[i]) for i in sorted(column)} for column in columns),
        A=_expressions(proof, A),
        H=_expressions(proof, H),
        B=None if B is None else _expressions(proof, B),
    )


def _as_printed(
    proof: Proof, inverse: Sequence[Row], columns: Sequence[Row]
) -> tuple[list[Row], list[Row], list[Covector]]:
    """Scale the rows of T⁻¹ to the linear forms as they are printed, and the columns of T the other way."""
    names, read = proof.exact.system.state_names, proof.exact.interpreter.read
    rows: list[Row] = []
    scaled: list[Row] = []
    printed: list[Covector] = []
    for row, column in zip(inverse, columns, strict=True):
        form = proof.covector(polynomial_row(proof.exact.field, row))
        first = min(row)
        scale = read(form[names[first]]) / row[first]
        rows.append({j: entry * scale for j, entry in row.items()})
        scaled.append({i: entry / scale for i, entry in column.items()})
        printed.append(form)
    return rows, scaled, printed


def _moved(exact: ExactSystem, columns: Sequence[Row]) -> tuple[Row, ...]:
    """Return A T − T' by rows."""
    moved = ({i: -entry for i, entry in drift(exact, column).items()} for column in columns)
    return transpose(moved, exact.n)


def _product(exact: ExactSystem, left: Sequence[Row], right: Sequence[Row]) -> tuple[Row, ...]:
    return tuple(combined(exact.field, ((entry, right[k]) for k, entry in row.items())) for row in left)


def _expressions(proof: Proof, rows: Sequence[Row]) -> Rows:
    restored = proof.restorer.element
    return tuple({j: restored(row[j]) for j in sorted(row)} for row in rows)


def _require_inverse(exact: ExactSystem, inverse: Sequence[Row], T: Sequence[Row]) -> None:
    one = exact.field.one
    for i, row in enumerate(_product(exact, inverse, T)):
        if row.keys() != {i} or row[i] != one:
            raise UndecidedError("the Kalman decomposition failed: T and its inverse do not multiply to 1")


def _require_zeros(sizes: Sequence[int], A: Sequence[Row], H: Sequence[Row], B: Sequence[Row] | None) -> None:
    wrong = filled_zeros(sizes, A, H, B)
    if wrong:
        raise UndecidedError(f"the Kalman decomposition failed: {', '.join(wrong)} should be zero")


def filled_zeros(
    sizes: Sequence[int],
    A: Sequence[Mapping[int, object]],
    H: Sequence[Mapping[int, object]],
    B: Sequence[Mapping[int, object]] | None,
) -> list[str]:
    """Return the blocks of Ā, H̄ and B̄ that should be zero and have entries: none where all is well.

    Parameters
    ----------
    sizes : of the parts
    A, H, B : sparse rows; B None for the two parts without inputs
    """
    part = [k for k, size in enumerate(sizes) for _ in range(size)]
    a_zeros, h_zeros = (_A_ZEROS_OF_TWO, _H_ZEROS_OF_TWO) if B is None else (_A_ZEROS, _H_ZEROS)
    wrong = [
        f"A{i + 1}{j + 1}" for i, j in a_zeros & {(part[i], part[j]) for i, r in enumerate(A) for j in r}
    ]
    wrong += [f"H{j + 1}" for j in h_zeros & {part[j] for row in H for j in row}]
    wrong += [f"B{i + 1}" for i in _B_ZEROS & {part[i] for i, row in enumerate(B or ()) if row}]
    return sorted(wrong)
