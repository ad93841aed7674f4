"""Whether a system in new variables z = S x is the old one, checked on what is printed.

    S' + S A = Ã S,   H = H̃ S,   S B = B̃,   S D Sᵀ = D̃,   S P0 Sᵀ = P̃0      D = G Q Gᵀ, without G: D = Q

With the first two every output of the new system from z(0) = S(0) x(0) is the output of the old one from
x(0). Nothing of the elimination that found the new system is used: its file is read, and the identities are
tried in a field that holds both.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from obscli.exact.errors import JetOverflowError
from obscli.exact.exact_system import ExactSystem, more_jets, read_system
from obscli.exact.rows import combined, dot, rate_of
from obscli.model.expression import Expression


if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from obscli.exact.exact_system import Row
    from obscli.exact.field import Element
    from obscli.model.system import Covector, Matrix, System


@dataclass(frozen=True, slots=True)
class Reproduction:
    """Which of the identities hold; None where there is nothing to compare."""

    dynamics: bool
    outputs: bool
    inputs: bool | None = None
    noise: bool | None = None


def reproduction(system: System, forms: Sequence[Covector], transformed: System) -> Reproduction:
    """Compare a system with the same one in the variables z = S x.

    Parameters
    ----------
    forms : S by rows, in the states of ``system``
    transformed : the system in z, whose parameters and functions are among those of ``system``

    Raises
    ------
    UndecidedError : zero cannot be decided for some coefficient, or they are too large
    UndefinedError : a coefficient does not exist
    """
    extra = [*_entries(transformed), *_entries(system)]
    extra += [entry for form in forms for entry in form.values()]
    exact = read_system(system, extra)
    while True:
        try:
            return _Comparison(exact, forms, transformed).result()
        except JetOverflowError:
            exact = more_jets(exact, extra)


def _entries(system: System) -> Iterator[Expression]:
    noise = system.noise
    matrices = (system.A, system.H, system.B, system.G, *((noise.Q, noise.P0) if noise else ()))
    for matrix in matrices:
        if matrix is not None:
            yield from matrix.entries.values()


class _Comparison:
    def __init__(self, exact: ExactSystem, forms: Sequence[Covector], transformed: System) -> None:
        self.exact, self.field = exact, exact.field
        self.old, self.new = exact.system, transformed
        self.S = [exact.row(form) for form in forms]

    def result(self) -> Reproduction:
        """Try every identity."""
        A, H = self._rows(self.new.A), self._rows(self.new.H)
        return Reproduction(
            dynamics=self._same([rate_of(self.exact, row) for row in self.S], self._product(A, self.S)),
            outputs=self._same(self.exact.H, self._product(H, self.S)),
            inputs=self._inputs(),
            noise=self._noise(),
        )

    def _inputs(self) -> bool | None:
        pairs = [(self.old.B, self.new.B)]
        pairs += [(self.old.G, self.new.G)] if self.old.G is not None else []
        found = [
            self._same(self._product(self.S, self._rows(old)), self._rows(new))
            for old, new in pairs
            if old is not None and new is not None
        ]
        return all(found) if found else None

    def _noise(self) -> bool | None:
        old, new = self.old.noise, self.new.noise
        if old is None or new is None:
            return None
        found = []
        if old.Q is not None and new.Q is not None:
            mine, other = self._density(self.old), self._density(self.new)
            found.append(self._same(self._congruent(mine), other))
        if old.P0 is not None and new.P0 is not None:
            whole, part = self._congruent(self._rows(old.P0)), self._rows(new.P0)
            known = {i for i, j in new.P0.entries if i == j}
            found.append(self._same([_within(row, known, i) for i, row in enumerate(whole)], part))
        return all(found) if found else None

    def _density(self, system: System) -> list[Row]:
        """Return D = G Q Gᵀ, without G: Q."""
        assert system.noise is not None
        assert system.noise.Q is not None
        Q = self._rows(system.noise.Q)
        if system.noise.driven == "states":
            return Q
        assert system.G is not None
        G = self._rows(system.G)
        return self._transposed_product(self._product(G, Q), G)

    def _congruent(self, matrix: Sequence[Row]) -> list[Row]:
        return self._transposed_product(self._product(self.S, matrix), self.S)

    def _product(self, left: Sequence[Row], right: Sequence[Row]) -> list[Row]:
        return [combined(self.field, ((e, right[k]) for k, e in row.items())) for row in left]

    def _transposed_product(self, left: Sequence[Row], right: Sequence[Row]) -> list[Row]:
        products = [{j: dot(self.field, row, other) for j, other in enumerate(right)} for row in left]
        return [{j: entry for j, entry in row.items() if entry} for row in products]

    def _rows(self, matrix: Matrix) -> list[Row]:
        rows: list[dict[int, Element]] = [{} for _ in range(matrix.rows)]
        for (i, j), expression in matrix.entries.items():
            element = self.exact.interpreter.read(expression)
            if element:
                rows[i][j] = element
        return list(rows)

    def _same(self, left: Sequence[Row], right: Sequence[Row]) -> bool:
        zero = self.field.zero
        return len(left) == len(right) and all(
            mine.get(j, zero) == other.get(j, zero)
            for mine, other in zip(left, right, strict=True)
            for j in mine.keys() | other.keys()
        )


def _within(row: Mapping[int, Element], known: set[int], i: int) -> dict[int, Element]:
    return {j: entry for j, entry in row.items() if i in known and j in known}
