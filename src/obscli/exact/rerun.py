"""A critical condition confirmed from both sides: the specialised system analysed anew, with proof."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from obscli.exact.errors import JetOverflowError
from obscli.exact.exact_system import more_jets, read_system
from obscli.exact.field import Element
from obscli.exact.kernel import dot
from obscli.exact.prove import prove_read
from obscli.exact.saturation import saturate
from obscli.model.specialise import Specialisation


if TYPE_CHECKING:
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
    if saturate(exact).rank == proof.rank:
        return None
    while True:
        try:
            lower = prove_read(exact, range(system.n))
            break
        except JetOverflowError:
            exact = more_jets(exact, extra)
    if lower.rank == proof.rank:
        return None
    lost = tuple(c for c, image in zip(proof.echelon, images, strict=True) if not _observable(lower, image))
    return Rerun(lower.rank, lost)


def _observable(proof: Proof, covector: Covector) -> bool:
    exact = proof.exact
    one = exact.field.one_polynomial
    index = {name: j for j, name in enumerate(exact.system.state_names)}
    row = {index[name]: exact.interpreter.read(e) for name, e in covector.items()}
    columns = proof.kernel.columns.values()
    return not any(dot(exact.field, row, {i: Element(exact.field, p, one) for i, p in c.items()}) for c in columns)
