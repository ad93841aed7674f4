"""The model without the states that cannot be estimated: what that assumes, and whether it loses anything.

The free states x_f of the unobservable directions are taken for zero: x_p' = A_pp x_p, y = H_p x_p is left.
With the reduced echelon form S = [1 | b], each state left stands in truth for x_p + Σ b_pf x_f; the model is
exact for these combinations where

    S' + S A = A_pp S,   H = H_p S

which holds where nothing moves the free states. Where it does not, what is left may have unobservable
directions of its own, and states are dropped again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from obscli.exact.prove import prove
from obscli.exact.reduced import Coordinates, in_variables
from obscli.exact.reproduction import Reproduction, reproduction
from obscli.model.expression import ONE, is_zero, negate
from obscli.model.options import Options, selected
from obscli.model.system import Covector, System
from obscli.model.trouble import Problems


@dataclass(frozen=True, slots=True, eq=False)
class Dropped:
    """A system without some states.

    Parameters
    ----------
    system : what is left; all of it, and no ``forms``, where nothing is observable
    states : the states dropped
    moved : those of them that other states move, so that they do not stay zero
    lost : inputs and disturbances that enter them and are dropped with them
    taken : quantities that are not observable and contain them, now taken with them zero
    forms : what each state left stands for, in the states of the whole system
    reproduction : which identities hold for these forms
    """

    system: System
    states: tuple[str, ...]
    moved: tuple[str, ...]
    lost: tuple[str, ...]
    taken: tuple[str, ...]
    forms: tuple[Covector, ...]
    reproduction: Reproduction

    @property
    def is_exact(self) -> bool:
        """Whether the model left is exact for what its states stand for, the lost inputs at zero."""
        return self.reproduction.dynamics and self.reproduction.outputs


def drop_unobservable(system: System, columns: Sequence[int], *, in_order: bool = False) -> Dropped:
    """Return the system without the states that are free in its unobservable directions.

    Parameters
    ----------
    columns : order of the states, those to keep first
    in_order : keep to that order; else states that do not move are dropped rather, where only that is exact

    Raises
    ------
    UndecidedError : a rank or a zero cannot be decided
    UndefinedError : a coefficient does not exist
    """
    found = _dropped(system, columns)
    if found.is_exact or in_order:
        return found
    moving = {i for i, j in system.A.entries if i != j or not system.discrete}
    other = _dropped(system, sorted(columns, key=lambda j: j not in moving))
    return other if other.is_exact else found


def _dropped(system: System, columns: Sequence[int]) -> Dropped:
    order = [system.state_names[j] for j in columns]
    left, states = system, tuple[str, ...]()
    first: Coordinates | None = None
    while True:
        proof = prove(left, [left.state_names.index(name) for name in order if name in left.state_names])
        free = tuple(left.state_names[f] for f in sorted(proof.kernel.columns))
        first = first or in_variables(system, proof.echelon, columns)
        if not free or len(free) == left.n:
            break
        left, states = without(left, free), (*states, *free)
    kept = tuple(form for form in _stand_for(first) if next(iter(form)) in left.state_names)
    nothing = Reproduction(dynamics=True, outputs=True)
    return Dropped(
        system=left,
        states=states,
        moved=_moved(system, states),
        lost=_lost(system, states),
        taken=_taken(first, states),
        forms=kept,
        reproduction=reproduction(system, kept, left) if kept else nothing,
    )


def without(system: System, states: Sequence[str]) -> System:
    """Return the system without some of its states."""
    return selected(system, Options({}, {}, (), states), Problems())


def _moved(system: System, dropped: Sequence[str]) -> tuple[str, ...]:
    names = system.state_names
    found = {names[i] for i, j in system.A.entries if names[j] not in dropped}
    return tuple(name for name in dropped if name in found)


def _lost(system: System, dropped: Sequence[str]) -> tuple[str, ...]:
    """Return the inputs and disturbances that enter dropped states, and the noise of these."""
    names, noise = system.state_names, system.noise
    found = []
    for matrix, driving in ((system.B, system.inputs), (system.G, system.disturbances)):
        entered = {k for i, k in (matrix.entries if matrix else ()) if names[i] in dropped}
        found += [name for k, name in enumerate(driving) if k in entered]
    if noise is not None and noise.Q is not None and noise.driven == "states":
        driven = {names[i] for (i, _), entry in noise.Q.entries.items() if not is_zero(entry)}
        found += [f"the noise of {name}" for name in dropped if name in driven]
    return tuple(found)


def _taken(coordinates: Coordinates, dropped: Sequence[str]) -> tuple[str, ...]:
    observable = {quantity.name for quantity, _ in coordinates.quantities}
    return tuple(
        one.name
        for one in coordinates.system.quantities
        if one.name not in observable and not one.coefficients.keys().isdisjoint(dropped)
    )


def _stand_for(coordinates: Coordinates) -> tuple[Covector, ...]:
    """Return x_p + Σ b_pf x_f for the pivots, in the order of the states."""
    return tuple(
        {state: ONE, **{name: negate(entry) for name, entry in found.free.items()}}
        for state, found in coordinates.back.items()
    )
