"""The noise of a system in new variables z = S x, where it can be carried over exactly.

Driving noise w of density Q keeps its density and enters by G̃ = S G; noise of the states themselves, which
has no G, enters by the columns of S. The noise of the outputs stays. An initial covariance becomes S P0 Sᵀ,
for the variables all of whose states have a prior; where that depends on time a file has no way to say it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from obscli.exact.errors import UndecidedError, UndefinedError
from obscli.exact.exact_system import ExactSystem, read_system
from obscli.exact.field import Element
from obscli.exact.hidden_dynamics import is_constant
from obscli.exact.reduced import Coordinates
from obscli.exact.rows import combined, dot
from obscli.model.expression import Expression, add, is_zero, multiply, power
from obscli.model.system import Matrix, Noise, System
from obscli.model.variables import free_name
from obscli.model.written import expanded_size


if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from obscli.exact.exact_system import Row

#: Variances of more parts than this are no use to a reader, and slow to read back.
_LONGEST: Final = 500
_TOO_LONG: Final = "the initial covariance is left out: S P0 S^T would be too long to read"
#: A file gives a full covariance of all states or of none.
_PARTLY: Final = (
    "the initial covariance is left out: it is known for some of the new variables only, which are correlated"
)


@dataclass(frozen=True, slots=True, eq=False)
class CarriedNoise:
    """Noise, the matrix G̃ and the names of its columns; ``notes``: what could not be carried over."""

    noise: Noise | None
    G: Matrix | None
    disturbances: tuple[str, ...]
    notes: tuple[str, ...] = ()


def carried_noise(coordinates: Coordinates, names: Sequence[str]) -> CarriedNoise:
    """Return the noise of a system in the variables of these names."""
    system = coordinates.system
    G = None if coordinates.G is None else matrix_of(coordinates.G, len(system.disturbances))
    noise = system.noise
    if noise is None:
        return CarriedNoise(None, G, system.disturbances)
    try:
        carry = _Carry(coordinates, noise, names)
        P0, notes = carry.prior()
        if noise.Q is None or noise.driven == "disturbances":
            return CarriedNoise(replace(noise, P0=P0), G, system.disturbances, notes)
        carried = carry.state_noise()
    except (UndecidedError, UndefinedError) as error:
        return CarriedNoise(None, G, system.disturbances, (f"noise is left out: {error}",))
    return replace(carried, noise=carried.noise and replace(carried.noise, P0=P0), notes=notes)


def matrix_of(rows: Sequence[Mapping[int, Expression]], columns: int) -> Matrix:
    """Return sparse rows as a matrix."""
    return Matrix(
        len(rows), columns, {(i, j): entry for i, row in enumerate(rows) for j, entry in row.items()}
    )


def _term(left: Expression, middle: Expression, right: Expression) -> Expression:
    """Return s P s'."""
    return multiply(power(left, 2), middle) if left is right else multiply(left, middle, right)


class _Carry:
    def __init__(self, coordinates: Coordinates, noise: Noise, names: Sequence[str]) -> None:
        self.noise, self.names, self.forms = noise, names, coordinates.forms
        self.system: System = coordinates.system
        extra = [entry for form in self.forms for entry in form.values()]
        extra += [e for matrix in (noise.Q, noise.P0) if matrix for e in matrix.entries.values()]
        self.exact: ExactSystem = read_system(self.system, extra)
        self.S = [self.exact.row(form) for form in self.forms]

    # -- the initial covariance

    def prior(self) -> tuple[Matrix | None, tuple[str, ...]]:
        """Return S P0 Sᵀ over the variables that have a constant prior, and remarks on the others."""
        given = self.noise.P0
        if given is None:
            return None, ()
        known = {i for i, j in given.entries if i == j}
        chosen = [k for k, row in enumerate(self.S) if row.keys() <= known]
        longest = self._product_of(given, [(k, k) for k in chosen]).entries.values()
        if max(map(expanded_size, longest), default=0) > _LONGEST:
            return None, (_TOO_LONG,)
        covariance = self._congruent(given, chosen)
        varying = {i for (i, j), e in covariance.items() if not is_constant(self.exact.field, {0: e})}
        kept = {(i, j): e for (i, j), e in covariance.items() if not {i, j} & varying}
        left_out = ", ".join(self.names[k] for k in sorted(varying))
        notes = (f"the initial covariance of {left_out} depends on time and is left out",) if varying else ()
        size = len(self.S)
        if any(i != j for i, j in kept) and sum(i == j for i, j in kept) < size:
            return None, (*notes, _PARTLY)
        return self._product_of(given, kept), notes

    def _congruent(self, matrix: Matrix, rows: Iterable[int]) -> dict[tuple[int, int], Element]:
        """Return the entries of S P Sᵀ in some rows and columns: the diagonal, and what is not zero."""
        P = self._rows(matrix)
        field, chosen = self.exact.field, list(rows)
        moved = {k: combined(field, ((e, P[j]) for j, e in self.S[k].items())) for k in chosen}
        entries = {(k, m): dot(field, moved[k], self.S[m]) for k in chosen for m in chosen}
        return {(k, m): entry for (k, m), entry in entries.items() if entry or k == m}

    def _product_of(self, matrix: Matrix, places: Iterable[tuple[int, int]]) -> Matrix:
        """Return entries of S P Sᵀ as they come of the products: multiplied out they would be long."""
        found: dict[tuple[int, int], Expression] = {}
        names = self.system.state_names
        for k, m in places:
            left, right = self.forms[k], self.forms[m]
            terms = [
                _term(left[names[i]], entry, right[names[j]])
                for (i, j), entry in matrix.entries.items()
                if names[i] in left and names[j] in right
            ]
            found[k, m] = add(*terms)
        return Matrix(len(self.forms), len(self.forms), found)

    def _rows(self, matrix: Matrix) -> list[Row]:
        rows: list[dict[int, Element]] = [{} for _ in range(matrix.rows)]
        for (i, j), expression in matrix.entries.items():
            rows[i][j] = self.exact.interpreter.read(expression)
        return list(rows)

    # -- noise of the states

    def state_noise(self) -> CarriedNoise:
        """Return Q̃ = S Q Sᵀ where that is a constant diagonal, else Q entering by the columns of S."""
        assert self.noise.Q is not None
        size = len(self.S)
        entries = self._congruent(self.noise.Q, range(size))
        if all(i == j and is_constant(self.exact.field, {0: e}) for (i, j), e in entries.items()):
            kept = self._product_of(self.noise.Q, [key for key, entry in entries.items() if entry])
            return CarriedNoise(replace(self.noise, Q=kept), None, ())
        return self._entering(self.noise.Q)

    def _entering(self, Q: Matrix) -> CarriedNoise:
        driven = sorted({i for (i, _), entry in Q.entries.items() if not is_zero(entry)})
        place = {i: k for k, i in enumerate(driven)}
        state_names = self.system.state_names
        names: list[str] = []
        for i in driven:
            names.append(free_name(self.system, f"w_{state_names[i]}", [*self.names, *names]))
        density: dict[tuple[int, int], Expression] = {
            (place[i], place[j]): entry for (i, j), entry in Q.entries.items() if i in place and j in place
        }
        G: dict[tuple[int, int], Expression] = {
            (k, place[i]): form[state_names[i]]
            for k, form in enumerate(self.forms)
            for i in driven
            if state_names[i] in form
        }
        noise = replace(self.noise, Q=Matrix(len(driven), len(driven), density), driven="disturbances")
        return CarriedNoise(noise, Matrix(len(self.forms), len(driven), G), tuple(names))
