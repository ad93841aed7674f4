"""What is checked of a model in new variables: on its file, read back, and by identities tried anew."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final

from obscli.core.check import CheckResult
from obscli.core.number import counted
from obscli.exact.errors import UndecidedError, UndefinedError
from obscli.exact.kalman import Kalman, filled_zeros
from obscli.exact.lift_finding import Stationary
from obscli.exact.prove import prove
from obscli.exact.reproduction import Reproduction, reproduction
from obscli.model.expression import Expression
from obscli.model.system import Covector, Matrix, System


_FOUR: Final = "A21 = A23 = A31 = A32 = A41 = A42 = A43 = 0, B3 = B4 = 0, H1 = H3 = 0"
_TWO: Final = "A12 = 0, H2 = 0"


def identity_checks(
    system: System, forms: Sequence[Covector], made: System, *, driven: bool = True
) -> tuple[CheckResult, ...]:
    """Check that a model is a system in the variables z = S x.

    Parameters
    ----------
    system : the system it comes from
    forms : S by rows
    made : the model as its file reads
    driven : compare inputs and noise too
    """
    try:
        found = reproduction(system, forms, made)
    except (UndecidedError, UndefinedError) as error:
        return (CheckResult("the model is the same system in new variables", "undecided", str(error)),)
    found = found if driven else replace(found, inputs=None, noise=None)
    return tuple(_identities(found, "S F = F_z S" if system.discrete else "S' + S A = A_z S"))


def _identities(found: Reproduction, dynamics: str) -> Iterator[CheckResult]:
    yield _check(f"every solution is carried over: {dynamics}", holds=found.dynamics)
    yield _check("every output is the same: H = H_z S", holds=found.outputs)
    if found.inputs is not None:
        yield _check("the inputs act the same: S B = B_z", holds=found.inputs)
    if found.noise is not None:
        yield _check("the noise in the file is the same: S Q S^T, S P0 S^T", holds=found.noise)


def rank_check(made: System, expected: int) -> CheckResult:
    """Prove the rank of the model as its file reads."""
    claim = (
        "every state is observable"
        if expected == made.n
        else f"{counted(expected, 'combination')} observable"
    )
    try:
        rank = prove(made, range(made.n)).rank
    except (UndecidedError, UndefinedError) as error:
        return CheckResult(claim, "undecided", str(error))
    return _check(claim, holds=rank == expected, grounds=f"rank {rank} of {made.n}, proved anew")


def agreement_check(found: Stationary) -> CheckResult:
    """Say whether the stationary system gives the observable combinations of the system itself."""
    claim = "its observable combinations, mapped back, are those of the system itself"
    count = counted(len(found.combinations), "combination")
    return _check(
        claim, holds=found.agrees, grounds=f"{count}, the same row space exactly" if found.agrees else ""
    )


def zeros_check(found: Kalman, made: System) -> CheckResult:
    """Check that the structural zeros of a decomposition are zeros in the file."""
    inputs = {"B": made.B, "G": made.G}.get(found.by or "")
    B = None if found.by is None else _rows(inputs or Matrix(made.n, 0, {}))
    wrong = filled_zeros(found.sizes, _rows(made.A), _rows(made.H), B)
    claim = f"the structural zeros: {_TWO if found.by is None else _FOUR}".replace("B3", f"{found.by}3")
    claim = claim.replace("B4", f"{found.by}4").replace("A", made.dynamics_name)
    return _check(claim, holds=not wrong, grounds=f"{', '.join(wrong)} not zero" if wrong else "")


def _rows(matrix: Matrix) -> list[dict[int, Expression]]:
    rows: list[dict[int, Expression]] = [{} for _ in range(matrix.rows)]
    for (i, j), entry in matrix.entries.items():
        rows[i][j] = entry
    return rows


def _check(claim: str, *, holds: bool, grounds: str = "") -> CheckResult:
    reason = grounds or ("exactly, on the file as it reads" if holds else "the two sides differ")
    return CheckResult(claim, "holds" if holds else "fails", reason)
