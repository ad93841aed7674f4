"""The structure of a system: the modes of the unobservable subspace, and whether all of them die out.

A system is detectable where every solution that no output shows tends to zero. Time-invariant hidden
dynamics decide that exactly, by Hurwitz determinants (those of a discrete-time system by its roots inside the
unit circle); for others the verdict is left open here, and the
Gramian's transition matrix looks at a period or a window.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from obscli.exact.echelon import polynomial_row
from obscli.exact.eigenvalue_text import eigenvalue_text
from obscli.exact.errors import JetOverflowError, UndecidedError, UndefinedError
from obscli.exact.exact_system import more_jets
from obscli.exact.hidden_dynamics import HiddenDynamics, constant_part, hidden_dynamics, transposed
from obscli.exact.hurwitz import Stability, has_parameters, roots_there, stability
from obscli.exact.kalman import kalman_dimensions
from obscli.exact.period import period
from obscli.exact.prove import Proof, prove, prove_read
from obscli.exact.schur import roots_inside, schur_stability
from obscli.exact.spectrum import characteristic_polynomial, factors, modes_of
from obscli.exact.structure_finding import Mode, OnCondition, Structure
from obscli.model.acting import inputs_of
from obscli.model.specialise import Specialisation, at_nominal


if TYPE_CHECKING:
    from obscli.exact.exact_system import Row
    from obscli.exact.field import Element
    from obscli.exact.finding import AtValues, CriticalSearch
    from obscli.exact.spectrum import Factor
    from obscli.exact.structure_finding import ModeKind, StructureVerdict
    from obscli.model.system import Covector

#: Why a verdict is open, or on what it rests where not all directions have constant coefficients.
VARIES: Final = "how the unobservable directions move depends on time"
PARTLY: Final = "the directions listed move by constant coefficients; that of the others depends on time"
BY_ITSELF: Final = "a part of the unobservable states moves by constant coefficients and does not die out"

#: Structures on more critical conditions than this are not computed.
_MOST_CONDITIONS: Final = 12


def structure_of(
    proof: Proof, at_values: AtValues | None = None, critical: CriticalSearch | None = None
) -> Structure:
    """Return the structure of a system whose rank is proved.

    Parameters
    ----------
    proof : the system, its kernel and rank
    at_values : the rank at the file's values; None: the structure there is not asked for
    critical : critical values, on which the structure is found too
    """
    found = _of_proof(proof)
    return replace(
        _with_parts(found, proof),
        at_values=None if at_values is None else _at_values(proof, found, at_values),
        critical=() if critical is None else tuple(_on_conditions(proof, critical)),
    )


def _at_values(proof: Proof, found: Structure, at_values: AtValues) -> Structure | None:
    """Return the structure at the file's values where the generic one does not say it already."""
    same = all(mode.kind_there == mode.kind for mode in found.modes)
    if at_values.rank is None or (at_values.rank == proof.rank and same):
        return None
    return _specialised(at_nominal(proof.exact.system), parts=True)


def _on_conditions(proof: Proof, critical: CriticalSearch) -> Iterator[OnCondition]:
    for one in critical.values[:_MOST_CONDITIONS]:
        if one.kind == "confirmed" and one.values:
            there = _specialised(Specialisation(proof.exact.system, one.values[0]))
            if there is not None:
                yield OnCondition(one.condition, there)


def _specialised(special: Specialisation, *, parts: bool = False) -> Structure | None:
    """Return the structure of a specialised system, None where its rank is not proved."""
    system = special.system()
    try:
        proof = prove(system, range(system.n))
    except (UndecidedError, UndefinedError):
        return None
    found = _of_proof(proof)
    return _with_parts(found, proof) if parts else found


def _with_parts(found: Structure, proof: Proof) -> Structure:
    """Return the structure with the dimensions of the Kalman decomposition, where there are inputs."""
    inputs = inputs_of(proof.exact.system)
    if inputs is None:
        return found
    while True:
        try:
            return replace(found, kalman=kalman_dimensions(proof), inputs=inputs.by)
        except JetOverflowError:
            proof = prove_read(more_jets(proof.exact), range(proof.exact.n), ())
        except (UndecidedError, UndefinedError):
            return replace(found, inputs=inputs.by)


def _of_proof(proof: Proof) -> Structure:
    dimension = len(proof.kernel.columns)
    if not dimension:
        return Structure(0, "observable")
    try:
        found = _of_kernel(proof)
    except (UndecidedError, JetOverflowError) as error:
        found = Structure(dimension, "undecided", reason=str(error) or "too many derivatives are needed")
    return replace(found, directions=tuple(proof.directions.values()))


def _of_kernel(proof: Proof) -> Structure:
    field, dynamics = proof.exact.field, hidden_dynamics(proof)
    dimension = len(dynamics.columns)
    if dynamics.decides == "all":
        modes, verdict, condition = _judged(proof, dynamics)
        reason = "the sign of a constant could not be found" if verdict == "undecided" else ""
        return Structure(dimension, verdict, condition, modes, reason)
    stays = constant_part(field, dynamics)
    modes, verdict, _ = _judged(proof, stays)
    if verdict == "not detectable":
        return Structure(dimension, verdict, "", modes, "" if len(modes) == dimension else PARTLY)
    if _judged(proof, constant_part(field, transposed(dynamics)))[1] == "not detectable":
        return Structure(dimension, "not detectable", "", modes, BY_ITSELF)
    return Structure(dimension, "undecided", "", modes, VARIES, period(proof))


def _judged(proof: Proof, dynamics: HiddenDynamics) -> tuple[tuple[Mode, ...], StructureVerdict, str]:
    """Return the modes of constant dynamics, the verdict on them, and on what it depends."""
    field = proof.exact.field
    modes: list[Mode] = []
    found: list[Stability] = []
    for factor in factors(field, characteristic_polynomial(field, dynamics.matrix)):
        known = (schur_stability if proof.exact.system.discrete else stability)(proof, factor)
        found.append(known)
        modes += _modes(proof, dynamics, factor, known)
    return tuple(modes), *_verdict(found)


def _verdict(found: Sequence[Stability]) -> tuple[StructureVerdict, str]:
    if any(one.never for one in found):
        return "not detectable", ""
    if any(one.kind == "undecided" for one in found):
        return "undecided", ""
    conditions = dict.fromkeys(one.condition for one in found if one.kind == "depends")
    return ("depends", " and ".join(conditions)) if conditions else ("detectable", "")


def _modes(proof: Proof, dynamics: HiddenDynamics, factor: Factor, known: Stability) -> Iterator[Mode]:
    text = eigenvalue_text(proof, factor)
    discrete = proof.exact.system.discrete
    values, there = (roots_inside if discrete else roots_there)(proof, factor)
    there = there if has_parameters(proof, factor.coefficients) else known.kind
    proper, rest = modes_of(proof.exact.field, dynamics.matrix, factor)
    for vector in proper:
        yield Mode(
            text,
            known.kind,
            _direction(proof, dynamics, vector),
            values,
            there,
            known.condition,
            discrete=discrete,
        )
    for vector in rest:
        direction = _direction(proof, dynamics, vector)
        kinds = (_chained(known.kind), _chained(there))
        yield Mode(
            text, kinds[0], direction, values, kinds[1], known.condition, chained=True, discrete=discrete
        )


def _chained(kind: ModeKind) -> ModeKind:
    """Return the kind of a direction that moves as t e^{λt}."""
    return "growing" if kind == "neutral" else kind


def _direction(proof: Proof, dynamics: HiddenDynamics, vector: Row) -> Covector:
    """Return N v as a readable direction."""
    field = proof.exact.field
    total: dict[int, Element] = {}
    for k, factor in vector.items():
        for j, entry in dynamics.columns[k].items():
            total[j] = total.get(j, field.zero) + entry * factor
    return proof.covector(polynomial_row(field, {j: entry for j, entry in total.items() if entry}))
