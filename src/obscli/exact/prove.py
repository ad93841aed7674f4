"""The rank of one system with its proof: saturation, elimination, kernel, certificate.

The generators of the field may depend on each other in secret; the proof does not mind. Upper bound:
identities in the free differential ring, true of the real functions because evaluation is a
homomorphism. Lower bound: one real minor. Where the two do not meet the rank is undecided.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

from obscli.exact.echelon import PolyRow
from obscli.exact.elimination import Flag, eliminate, everything
from obscli.exact.errors import JetOverflowError, UndecidedError
from obscli.exact.exact_system import ExactSystem, more_jets, read_system
from obscli.exact.few_rows import most_rows
from obscli.exact.field import Element
from obscli.exact.finding import Certificate, LowerBound, UpperBound
from obscli.exact.identity import fingerprint, independent_constants
from obscli.exact.kernel import Kernel, invariant_kernel, kernel_columns
from obscli.exact.lower import prove_lower_bound
from obscli.exact.nonzero import require_nonzero
from obscli.exact.restore import Restorer
from obscli.exact.rows import dot, field_row
from obscli.exact.saturation import Saturation, saturate
from obscli.model.expression import Expression
from obscli.model.system import Covector, System


@dataclass(frozen=True, eq=False)
class Proof:
    """A system read exactly, its reduced echelon form, kernel and lower bound: the rank is proved."""

    exact: ExactSystem
    saturation: Saturation
    flag: Flag
    kernel: Kernel
    lower: LowerBound
    restorer: Restorer

    @property
    def rank(self) -> int:
        """The generic rank."""
        return self.saturation.rank

    @property
    def order(self) -> int:
        """The order at which the observability matrix saturates."""
        return self.saturation.order

    @cached_property
    def echelon(self) -> tuple[Covector, ...]:
        """The reduced echelon form as readable combinations, by pivot."""
        return tuple(self.covector(row) for _, row in sorted(self.flag.rows.items()))

    @cached_property
    def directions(self) -> dict[int, Covector]:
        """The kernel columns as readable directions, by free state."""
        return {free: self.covector(column) for free, column in self.kernel.columns.items()}

    def covector(self, row: PolyRow) -> Covector:
        """Return a polynomial row as a readable linear form, states in order."""
        names = self.exact.system.state_names
        restored = self.restorer.row(row)
        return {names[j]: restored[j] for j in sorted(restored)}


def prove(system: System, columns: Sequence[int], extra: Iterable[Expression] = (), jets: int = 4) -> Proof:
    """Compute and prove the generic rank of the observability matrix of a system.

    Parameters
    ----------
    columns : order of the states in which pivots are sought
    extra : further expressions to be read in the same field
    jets : how many derivatives of each unspecified function to begin with

    Raises
    ------
    UndecidedError : zero or the rank cannot be decided; the text says why
    UndefinedError : a coefficient does not exist
    """
    extra = tuple(extra)
    return prove_read(read_system(system, extra, jets), columns, extra)


def prove_read(exact: ExactSystem, columns: Sequence[int], extra: Sequence[Expression]) -> Proof:
    """Compute and prove the rank of a system that has been read together with ``extra``.

    The system is read again with more derivatives of its functions where they run out.
    """
    while True:
        try:
            return _prove(exact, columns)
        except JetOverflowError:
            exact = more_jets(exact, extra)


def _prove(exact: ExactSystem, columns: Sequence[int]) -> Proof:
    saturation = saturate(exact)
    flag = _flag(exact, saturation, columns)
    kernel = invariant_kernel(exact, kernel_columns(exact.field, flag.rows, columns))
    lower = prove_lower_bound(exact.system, exact.interpreter, saturation.rows, list(flag.rows))
    proof = Proof(exact, saturation, flag, kernel, lower, Restorer(exact.interpreter))
    # the rank is proved; that every coefficient printed differs from zero is proved here
    require_nonzero(exact.interpreter, [e for row in proof.echelon for e in row.values()])
    return proof


def _flag(exact: ExactSystem, saturation: Saturation, columns: Sequence[int]) -> Flag:
    """Return the reduced echelon form; of full rank, it is known without the elimination.

    That is taken where the elimination is too much, and the order is evident: fewer derivatives give fewer
    rows than states.
    """
    try:
        return eliminate(exact, saturation, columns)
    except UndecidedError:
        if saturation.rank < exact.n or most_rows(exact, saturation.order - 1) >= exact.n:
            raise
        return everything(exact)


def certificate(proof: Proof) -> Certificate:
    """Return the certificate of a proof, in expressions of the model's grammar."""
    return Certificate(
        model=fingerprint(proof.exact.system),
        rank=proof.rank,
        order=proof.order,
        lower=proof.lower,
        upper=_upper_bound(proof),
        assumes=independent_constants(proof.exact),
    )


def _upper_bound(proof: Proof) -> UpperBound:
    """Write N and X with each column of N scaled as it is printed: N D, and X becomes D⁻¹(X D + D')."""
    exact, restorer = proof.exact, proof.restorer
    names = exact.system.state_names
    free = list(proof.kernel.columns)
    printed = proof.directions
    scale = {f: _scale(proof, f, printed[f][names[f]]) for f in free}
    zero = exact.field.zero
    columns = []
    for f in free:
        x = proof.kernel.multiplier[f]
        entries = {g: x.get(g, zero) * scale[f] / scale[g] for g in free if g in x}
        entries[f] = entries.get(f, zero) + exact.field.derive(scale[f]) / scale[f]
        columns.append(tuple(restorer.element(entries.get(g, zero)) for g in free))
    return UpperBound(tuple(printed.values()), tuple(columns), _delay(proof))


def _scale(proof: Proof, free: int, printed: Expression) -> Element:
    field = proof.exact.field
    entry = Element(field, proof.kernel.columns[free][free], field.one_polynomial)
    return proof.exact.interpreter.read(printed) / entry


def _delay(proof: Proof) -> Covector | None:
    """Return a direction that the rows below the saturation order do not see, and the order does.

    None where no proof of the order is needed: there are too few rows below it.
    """
    if proof.order == 0 or not proof.flag.eliminated:
        return None
    earlier = proof.flag.before_last
    columns = kernel_columns(proof.exact.field, earlier, range(proof.exact.n))
    pivots = next(free for free in columns if _seen(proof, columns[free]))
    return proof.covector(columns[pivots])


def _seen(proof: Proof, column: PolyRow) -> bool:
    """Whether some observable combination changes along the direction."""
    field = proof.exact.field
    direction = field_row(field, column)
    return any(dot(field, field_row(field, row), direction) for row in proof.flag.rows.values())
