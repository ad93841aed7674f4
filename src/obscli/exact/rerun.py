"""A critical condition confirmed from both sides: the specialised system analysed anew, with proof."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from obscli.exact.errors import UndecidedError
from obscli.exact.exact_system import read_system
from obscli.exact.lower import prove_lower_bound
from obscli.exact.nonzero import first_nonzero
from obscli.exact.prove import prove_read
from obscli.exact.rows import dot, field_row
from obscli.exact.saturation import stays_independent
from obscli.model.specialise import Specialisation


if TYPE_CHECKING:
    from obscli.exact.exact_system import ExactSystem
    from obscli.exact.prove import Proof
    from obscli.model.expression import Expression
    from obscli.model.system import Covector


@dataclass(frozen=True, slots=True, eq=False)
class Rerun:
    """The proved rank on the specialised system, and the generic combinations that are lost there."""

    rank: int
    lost: tuple[Covector, ...]


def rerun(
    proof: Proof, values: Mapping[str, Expression], rules: Mapping[str, Expression] | None = None
) -> Rerun | None:
    """Return the rank of the specialised system if it is lower, else None.

    Raises
    ------
    UndefinedError : a coefficient does not exist on the specialised system
    UndecidedError : the rank there cannot be proved
    """
    special = Specialisation(proof.exact.system, values, rules)
    system = special.system()
    images = [special.covector(combination) for combination in proof.echelon]
    extra = [e for image in images for e in image.values()]
    exact = read_system(system, extra)
    if stays_independent(exact, proof.saturation) and _really(proof, exact):
        return None
    lower = prove_read(exact, range(system.n), extra)
    if lower.rank >= proof.rank:
        return None
    return Rerun(lower.rank, _lost(proof, lower, images))


def _really(proof: Proof, exact: ExactSystem) -> bool:
    """Whether the generic minor is seen to differ from zero on the specialised system in real numbers.

    The generators may depend on each other there in secret, and then the screen modulo a prime means nothing.
    """
    try:
        prove_lower_bound(
            exact.system, exact.interpreter, proof.saturation.rows, list(proof.flag.rows), patient=False
        )
    except UndecidedError:
        return False
    return True


def _lost(proof: Proof, lower: Proof, images: Sequence[Covector]) -> tuple[Covector, ...]:
    """Return the generic combinations whose image on the specialised system vanishes or is not observable."""
    exact = lower.exact
    columns = [field_row(exact.field, column) for column in lower.kernel.columns.values()]
    rows = [exact.row(image) for image in images]
    return tuple(
        combination
        for combination, row in zip(proof.echelon, rows, strict=True)
        if not row
        or first_nonzero(exact.interpreter, [dot(exact.field, row, column) for column in columns]) is not None
    )
