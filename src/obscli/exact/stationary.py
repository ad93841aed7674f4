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

from obscli.exact.closure import closure
from obscli.exact.closure_screen import Screen
from obscli.exact.constant_span import Forms
from obscli.exact.errors import UndecidedError, UndefinedError
from obscli.exact.exponential_polynomial import Expansion, NotExponentialError
from obscli.exact.finding import Undecided
from obscli.exact.kronecker import full_columns, functions_in, kronecker
from obscli.exact.lift_finding import NotReducible, Obstacle, Stationary
from obscli.exact.lift_observability import chains_of, combinations
from obscli.exact.lift_writing import Writer
from obscli.exact.modes import Modes
from obscli.exact.prove import prove
from obscli.exact.same_order import same_order


if TYPE_CHECKING:
    from collections.abc import Iterator

    from obscli.exact.exact_system import Row
    from obscli.exact.field import Element
    from obscli.exact.lift_finding import Chain
    from obscli.exact.mode import Mode
    from obscli.exact.prove import Proof
    from obscli.model.system import System

#: A space of forms with more terms than this, each a function times a state, is taken for one that does not
#: close, unless A and H themselves have as many.
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
        self.modes = Modes(proof.exact)
        self.expansion = Expansion(self.modes, proof.restorer)
        self.obstacles: list[Obstacle] = []

    def run(self) -> Stationary | NotReducible:
        """Expand the coefficients, see whether the outputs close, and find everything else."""
        A = self._expanded("A", self.proof.exact.A)
        H = self._expanded("H", self.proof.exact.H)
        if not self.obstacles:
            forms = Forms(self.modes, A, H)
            screen, most = Screen(forms), _most(forms)
            if screen.closes(forms.H, most):
                return self._stationary(forms, screen, most)
            self.obstacles += self._growing(forms, most)
        return NotReducible(self.system, tuple(self.obstacles))

    def _expanded(self, name: str, rows: tuple[Row, ...]) -> tuple[dict[int, dict[Mode, Element]], ...]:
        """Return the entries of a matrix as sums of modes, and note those that are none."""
        result: list[dict[int, dict[Mode, Element]]] = []
        for i, row in enumerate(rows):
            result.append({})
            for j, entry in row.items():
                try:
                    result[-1][j] = self.expansion(entry)
                except NotExponentialError as error:
                    self.obstacles.append(self._obstacle(name, i, j, str(error)))
        return tuple(result)

    def _obstacle(self, name: str, i: int, j: int, reason: str) -> Obstacle:
        matrix, rows = self.system.A, self.system.state_names
        if name == "H":
            matrix, rows = self.system.H, tuple(output.name for output in self.system.outputs)
        place = matrix.places.get((i, j))
        return Obstacle(f"{name}[{rows[i]}, {self.system.state_names[j]}]", str(place or ""), reason)

    def _growing(self, forms: Forms, most: int) -> Iterator[Obstacle]:
        """Yield the entries of A that vary and act on states that move."""
        reason = (
            "multiplies a state that moves, and with every derivative of the outputs new functions of time "
            f"come in: the search ended at {most} terms, each a function times a state"
        )
        for i in forms.moving:
            for j, entry in forms.A[i].items():
                if j in forms.moving and set(entry) != {self.modes.one}:
                    yield self._obstacle("A", i, j, reason)

    def _stationary(self, forms: Forms, screen: Screen, most: int) -> Stationary:
        closing = [i for i in forms.moving if forms.closes or screen.closes([forms.state(i)], most)]
        wanted = [forms.state(i) for i in closing] + list(forms.H)
        writer = Writer(forms, self.proof.restorer)
        seen = closure(forms, forms.H, screen.finite(forms.H))
        found, agrees = combinations(self.proof, seen)
        same = same_order(forms, screen)
        return Stationary(
            system=self.system,
            functions=writer.functions(functions_in(forms)),
            full=kronecker(forms, writer, seen.dimension),
            smallest=writer.lift(closure(forms, wanted, screen.finite(wanted))),
            observable=writer.lift(seen),
            same_order=None if same is None else writer.lift(same),
            rank=seen.dimension,
            chains=_chains(forms, screen, writer),
            combinations=found,
            agrees=agrees,
            left_out=tuple(self.system.state_names[i] for i in forms.moving if i not in closing),
        )


def _most(forms: Forms) -> int:
    """Return in how many columns spaces are searched: all there are of the full lift, where there is one."""
    columns = full_columns(forms)
    if columns is not None:
        return len(columns)
    own = len(forms.A) * len(functions_in(forms))
    return max(own, min(_MOST, 4 * own))


def _chains(forms: Forms, screen: Screen, writer: Writer) -> tuple[Chain, ...]:
    try:
        return chains_of(forms, screen, writer)
    except UndecidedError:
        return ()
