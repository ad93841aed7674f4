"""Reducible systems: stationary systems in new variables, found by algorithm.

    z = V(t) x,   z' = A_z z,   y = H_z z     with     V' + V A = A_z V,   H = H_z V

The coefficients of A(t), H(t) are read as exponential polynomials; linear forms in the states with such
coefficients are vectors over the constants; spaces of them that are closed under l ↦ l' + l A are stationary
systems. Where the rows of H lie in no space of finite dimension there is none of this kind.

References
----------
Morozov & Baklanov 2018, section 5, (13)–(22).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from obscli.exact.closure import Screen, closure
from obscli.exact.constant_span import Forms
from obscli.exact.errors import UndecidedError, UndefinedError
from obscli.exact.exponential_polynomial import Modes, NotExponentialError
from obscli.exact.finding import Undecided
from obscli.exact.kronecker import full_columns, functions_in, kronecker
from obscli.exact.lift_finding import NotReducible, Obstacle, Stationary
from obscli.exact.lift_observability import combinations, observed
from obscli.exact.lift_writing import Writer
from obscli.exact.prove import prove
from obscli.exact.same_order import same_order


if TYPE_CHECKING:
    from obscli.exact.exact_system import Row
    from obscli.exact.exponential_polynomial import Mode
    from obscli.exact.field import Element
    from obscli.exact.prove import Proof
    from obscli.model.system import System

#: A space of forms with more dimensions than this is taken for one that does not close.
_MOST: Final = 500


def find_stationary(system: System) -> Stationary | NotReducible | Undecided:
    """Return the stationary systems that a system reduces to, or why there are none, or why that is open."""
    try:
        return stationary_of(prove(system, range(system.n)))
    except (UndecidedError, UndefinedError) as error:
        return Undecided(system, str(error))


def stationary_of(proof: Proof) -> Stationary | NotReducible:
    """Return the stationary systems that a system of proved rank reduces to, or what stands in the way.

    Raises
    ------
    UndecidedError : the coefficients grow too large; for a discrete-time system
    """
    if proof.exact.system.discrete:
        raise UndecidedError("stationary systems are those of systems in continuous time")
    return _Search(proof).run()


class _Search:
    def __init__(self, proof: Proof) -> None:
        self.proof, self.system = proof, proof.exact.system
        self.modes = Modes(proof.exact, proof.restorer)
        self.obstacles: list[Obstacle] = []

    def run(self) -> Stationary | NotReducible:
        A = self._expanded("A", self.proof.exact.A)
        H = self._expanded("H", self.proof.exact.H)
        if self.obstacles:
            return NotReducible(self.system, tuple(self.obstacles))
        return self._reduced(Forms(self.modes, A, H))

    def _expanded(self, name: str, rows: tuple[Row, ...]) -> tuple[dict[int, dict[Mode, Element]], ...]:
        """Return the entries of a matrix as sums of modes, and note those that are none."""
        result: list[dict[int, dict[Mode, Element]]] = []
        for i, row in enumerate(rows):
            result.append({})
            for j, entry in row.items():
                try:
                    result[-1][j] = self.modes.expand(entry)
                except NotExponentialError as error:
                    self.obstacles.append(self._obstacle(name, i, j, str(error)))
        return tuple(result)

    def _obstacle(self, name: str, i: int, j: int, reason: str) -> Obstacle:
        rows = self.system.state_names if name == "A" else tuple(one.name for one in self.system.outputs)
        place = (self.system.A if name == "A" else self.system.H).places.get((i, j))
        return Obstacle(f"{name}[{rows[i]}, {self.system.state_names[j]}]", str(place or ""), reason)

    def _reduced(self, forms: Forms) -> Stationary | NotReducible:
        screen = Screen(forms)
        most = self._most(forms)
        if screen.closure(forms.H, most) is None:
            return NotReducible(self.system, self._growing(forms, "outputs", most))
        closing = [i for i in forms.moving if screen.closure([forms.state(i)], most) is not None]
        wanted = [forms.state(i) for i in closing] + list(forms.H)
        screen.closure(wanted, 2 * most)
        writer = Writer(forms, self.proof.restorer)
        seen, chains = observed(forms, writer)
        found, agrees = combinations(self.proof, seen)
        same = same_order(forms, screen)
        return Stationary(
            system=self.system,
            functions=writer.functions(functions_in(forms)),
            full=kronecker(forms, writer, seen.dimension),
            smallest=writer.lift(closure(forms, wanted)),
            observable=writer.lift(seen),
            same_order=None if same is None else writer.lift(same),
            rank=seen.dimension,
            chains=chains,
            combinations=found,
            agrees=agrees,
        )

    def _most(self, forms: Forms) -> int:
        """Return how many dimensions a space may have: of the full lift, where there is one."""
        columns = full_columns(forms)
        if columns is not None:
            return len(columns)
        return min(_MOST, 4 * len(forms.A) * len(functions_in(forms)))

    def _growing(self, forms: Forms, what: str, most: int) -> tuple[Obstacle, ...]:
        """Return the entries of A that vary and act on moving states."""
        reason = (
            f"acts on a state that moves, and the derivatives of the {what} bring ever new functions of time: "
            f"more than {most} variables would not do"
        )
        return tuple(
            self._obstacle("A", i, j, reason)
            for i in forms.moving
            for j, entry in forms.A[i].items()
            if j in forms.moving and set(entry) != {self.modes.one}
        )
