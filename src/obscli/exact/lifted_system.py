"""A stationary lift z = V(t) x as a system of its own, which every LTI tool can take."""

from __future__ import annotations

from dataclasses import replace

from obscli.exact.carried_noise import matrix_of
from obscli.exact.lift_finding import Lift
from obscli.model.notation import covector_text
from obscli.model.system import Covector, State, System
from obscli.model.used import without_unused
from obscli.model.variables import is_state


def lifted_system(system: System, lift: Lift) -> tuple[System, tuple[str, ...]]:
    """Return the system z' = A_z z, y = H_z z, and what of the old one is not carried over.

    The noise of the outputs stays. What drives the states, inputs and priors would need V(t) in the file.
    """
    states = tuple(_state(system, *one) for one in zip(lift.names, lift.variables, strict=True))
    kept = system.noise and replace(system.noise, Q=None, P0=None, driven="states")
    made = replace(
        system,
        stage=None,
        states=states,
        A=matrix_of(lift.A, lift.n),
        H=matrix_of(lift.H, lift.n),
        B=None,
        G=None,
        inputs=(),
        disturbances=(),
        quantities=(),
        noise=kept if kept and kept.R is not None else None,
        prior={},
        claims=(),
        scope=None,
    )
    return without_unused(made), tuple(_lost(system))


def _state(system: System, name: str, form: Covector) -> State:
    if is_state(form):
        return replace(next(one for one in system.states if one.name in form), vector="")
    first = next(one for one in system.states if one.name in form)
    return State(name, first.place, description=covector_text(form, system.state_names))


def _lost(system: System) -> list[str]:
    """Say what a stationary system cannot carry."""
    noise = system.noise
    lost = [
        *(["inputs"] if system.inputs else []),
        *(["driving noise"] if noise is not None and noise.Q is not None else []),
        *(["the prior"] if noise is not None and noise.P0 is not None else []),
        *(["quantities"] if system.quantities else []),
    ]
    return [f"not carried over, since z = V(t) x depends on time: {', '.join(lost)}"] if lost else []
