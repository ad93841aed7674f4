"""A system in new variables as a system of its own, with everything that carries over."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from obscli.exact.carried_noise import carried_noise, matrix_of
from obscli.exact.reduced import Coordinates
from obscli.model.prior import prior_deviations
from obscli.model.system import Quantity, System
from obscli.model.used import without_unused
from obscli.model.variables import variable_states


def transformed_system(coordinates: Coordinates) -> tuple[System, tuple[str, ...]]:
    """Return the system in the new variables, and what of the old one could not be carried over.

    The states that the new variables determine, and are not variables themselves, become quantities.
    """
    system = coordinates.system
    states = variable_states(system, coordinates.forms)
    names = tuple(state.name for state in states)
    carried = carried_noise(coordinates, names)
    result = replace(
        system,
        stage=None,
        states=states,
        A=matrix_of(coordinates.A, len(states)),
        H=matrix_of(coordinates.H, len(states)),
        B=None if coordinates.B is None else matrix_of(coordinates.B, len(system.inputs)),
        G=carried.G,
        disturbances=carried.disturbances,
        noise=carried.noise,
        prior=prior_deviations(carried.noise, states),
        quantities=(*_carried(coordinates, names), *_states_back(coordinates, names)),
        claims=(),
        scope=None,
    )
    return without_unused(result), (*carried.notes, *_lost(coordinates))


def _carried(coordinates: Coordinates, names: Sequence[str]) -> Iterator[Quantity]:
    for quantity, z in coordinates.quantities:
        yield replace(quantity, coefficients={names[k]: entry for k, entry in z.items()}, text="")


def _states_back(coordinates: Coordinates, names: Sequence[str]) -> Iterator[Quantity]:
    """Yield the states that are functions of the new variables without being any of them."""
    for state in coordinates.system.states:
        found = coordinates.back.get(state.name)
        if found is not None and not found.free and state.name not in names:
            z = {names[k]: entry for k, entry in found.variables.items()}
            yield Quantity(state.name, z, state.place)


def _lost(coordinates: Coordinates) -> Iterator[str]:
    kept = {quantity.name for quantity, _ in coordinates.quantities}
    lost = [quantity.name for quantity in coordinates.system.quantities if quantity.name not in kept]
    if lost:
        yield f"not observable, and left out: {', '.join(lost)} (quantities)"
