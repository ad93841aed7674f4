"""What measures are taken of: states, quantities, combinations, and which of them are observable."""

from __future__ import annotations

from obscli.exact.finding import Analysis, LinearFormVerdict, Undecided
from obscli.measures.subject import Target
from obscli.model.expression import ONE, is_one
from obscli.model.notation import covector_text
from obscli.model.specialise import at_nominal
from obscli.model.system import Covector, System


def targets_of(system: System, analysis: Analysis, generic: Analysis | Undecided) -> tuple[Target, ...]:
    """Return states, quantities and the combinations that are no single state, with what is known of each.

    Parameters
    ----------
    system : as the file has it
    analysis : of the system at the file's values
    generic : of the system; its combinations are shown where they tell the same at the file's values
    """
    alike = (
        isinstance(generic, Analysis) and generic.rank == analysis.rank and generic.states == analysis.states
    )
    shown = generic.combinations if alike and isinstance(generic, Analysis) else analysis.combinations
    there = at_nominal(system)
    states = [
        Target(name, "state", {name: ONE}, analysis.states[name] == "observable")
        for name in system.state_names
    ]
    quantities = [
        Target(one.name, "quantity", there.covector(one.coefficients), _known(verdict.verdict))
        for one, verdict in zip(system.quantities, analysis.quantities, strict=True)
    ]
    combinations = [
        Target(
            covector_text(one.coefficients, system.state_names),
            "combination",
            one.coefficients,
            observable=True,
        )
        for one in shown
        if not _is_state(one.coefficients)
    ]
    return (*states, *quantities, *combinations)


def _known(verdict: LinearFormVerdict) -> bool | None:
    return None if verdict == "undecided" else verdict == "observable"


def _is_state(covector: Covector) -> bool:
    return len(covector) == 1 and all(is_one(entry) for entry in covector.values())
