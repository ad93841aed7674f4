"""What a simulation follows in one stage: linear forms with verdicts, samples of outputs, requirements.

Importing this costs the floating-point libraries.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from obscli.exact.analysis import analyze
from obscli.exact.finding import Analysis, LinearFormVerdict, Undecided
from obscli.exact.why import LIGHT
from obscli.model.expression import ONE, is_one, symbols
from obscli.model.notation import covector_text
from obscli.model.specialise import at_nominal
from obscli.model.system import Covector, Requirement, System
from obscli.numeric.errors import NotComputableError
from obscli.numeric.linear_forms import Forms, forms_of
from obscli.numeric.numeric_system import constants_of
from obscli.numeric.program import Array, constant_value
from obscli.numeric.schedule import Schedule
from obscli.numeric.simulation_finding import Followed
from obscli.pipelines.simulate_result import FollowedForm, Sampling


def followed_forms(system: System) -> tuple[tuple[FollowedForm, ...], str]:
    """Return states, quantities and observable combinations with verdicts at the file's values.

    Combinations that are single states are not repeated. The text says why there are no verdicts.
    """
    return forms_from(system, _at_values(system))


def forms_from(system: System, found: Analysis | Undecided) -> tuple[tuple[FollowedForm, ...], str]:
    """Return the same from an analysis that holds at the file's values."""
    verdicts: dict[str, LinearFormVerdict] = {}
    combinations: tuple[Covector, ...] = ()
    if isinstance(found, Analysis):
        verdicts = {**found.states, **{one.name: one.verdict for one in found.quantities}}
        combinations = tuple(one.coefficients for one in found.combinations)
    units = {one.name: one.unit for one in system.states}
    states = (
        FollowedForm(one.name, "state", one.unit, {one.name: ONE}, verdicts.get(one.name))
        for one in system.states
    )
    others: list[tuple[str, Followed, Covector]] = [
        *((one.name, "quantity", one.coefficients) for one in system.quantities),
        *(
            (covector_text(one, system.state_names), "combination", one)
            for one in combinations
            if len(one) > 1
        ),
    ]
    rest = (
        FollowedForm(
            name,
            kind,
            _unit(covector, units),
            covector,
            verdicts.get(name) if kind == "quantity" else "observable",
        )
        for name, kind, covector in others
    )
    return (*states, *rest), found.reason if isinstance(found, Undecided) else ""


def linear_forms(system: System, forms: Iterable[FollowedForm]) -> Forms:
    """Return what is followed in numbers: states, quantities and the combinations."""
    return forms_of(system, [(one.name, one.coefficients) for one in forms if one.kind == "combination"])


def _at_values(system: System) -> Analysis | Undecided:
    """Return the exact analysis where it has the rank of the file's values."""
    found = analyze(system, LIGHT)
    if isinstance(found, Undecided) or found.at_values.rank == found.rank:
        return found
    return analyze(at_nominal(system).system(), LIGHT)


def _unit(covector: Covector, units: dict[str, str]) -> str:
    """Return the unit of a state that is itself the form; of other forms the file gives none."""
    one = len(covector) == 1 and all(is_one(value) for value in covector.values())
    return units[next(iter(covector))] if one else ""


def sampling_of(parts: Sequence[tuple[System, Schedule]]) -> tuple[Sampling, ...]:
    """Return when each output is sampled, and where it is not for longer than usual.

    Parameters
    ----------
    parts : of the interval, one after the other: what is in force, and when it is sampled
    """
    names = dict.fromkeys(output.name for system, _ in parts for output in system.outputs)
    return tuple(_sampling(name, [(_samples(name, *one), one[1]) for one in parts]) for name in names)


def _samples(name: str, system: System, schedule: Schedule) -> Array:
    """Return when an output is sampled in a part of the interval; never where it does not exist."""
    place = [k for k, one in enumerate(system.outputs) if one.name == name]
    return schedule.t[schedule.sampled[:, place].any(axis=1)]


def _sampling(name: str, parts: Sequence[tuple[Array, Schedule]]) -> Sampling:
    each = [one for one, _ in parts]
    t = np.concatenate(each)
    known = [float(np.diff(own).min()) for own in each if len(own) > 1]
    usual = known or ([float(np.diff(t).min())] if len(t) > 1 else [0.0])
    own = np.array([np.diff(one).min() if len(one) > 1 else max(usual) for one in each])
    part = np.concatenate([[0], np.repeat(np.arange(len(each)), [len(one) for one in each]), [len(each) - 1]])
    edges = np.concatenate([[parts[0][1].start], t, [parts[-1][1].stop]])
    long = np.diff(edges) > 1.5 * np.maximum(own[part[:-1]], own[part[1:]])
    outages = tuple((float(edges[j]), float(edges[j + 1])) for j in np.flatnonzero(long))
    every, longest = (min(usual), max(usual)) if len(t) > 1 else (None, None)
    return Sampling(name, len(t), every, outages, longest)


def demands_of(system: System, requirements: Iterable[Requirement]) -> dict[str, float]:
    """Return the deviations that the file requires of the system's states and quantities, by name."""
    names = {*system.state_names, *(one.name for one in system.quantities)}
    constants = constants_of(system)
    found = {}
    for one in requirements:
        if one.name not in names:
            continue
        without_value = sorted(symbols(one.value) - constants.keys())
        if without_value:
            raise NotComputableError(
                f"`require` of {one.name} depends on {', '.join(without_value)}: give a value with --set"
            )
        found[one.name] = constant_value(one.value, constants)
    return found
