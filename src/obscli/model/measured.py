"""A system with one more output."""

from __future__ import annotations

from dataclasses import replace

from obscli.model.system import Covector, Matrix, Output, System


def with_output(system: System, covector: Covector, name: str = "") -> System:
    """Return the system with a linear form in the states measured as well, without noise of its own.

    Parameters
    ----------
    name : of the new output; empty: one that nothing else has
    """
    known = {one.name for one in system.outputs}
    name = name or next(f"measured{k}" for k in range(1, len(known) + 2) if f"measured{k}" not in known)
    place = system.states[0].place
    index = {state: j for j, state in enumerate(system.state_names)}
    entries = {(system.m, index[state]): entry for state, entry in covector.items()}
    return replace(
        system,
        outputs=(*system.outputs, Output(name, place)),
        H=Matrix(system.m + 1, system.n, {**system.H.entries, **entries}, system.H.places),
        noise=None,
        claims=(),
    )
