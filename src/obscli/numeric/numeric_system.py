"""A system as functions from instants to arrays: A(t), H(t) in batches, at the file's values.

x' = A x,  y = H x.  Only the rows of A that are not zero are kept: most states of a calibration are constant,
and what follows multiplies (p, n) instead of (n, n) matrices, p the number of states that move. Of a
discrete-time system A is F, of which every row counts.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from obscli.model.expression import Derivative, Expression, postorder, symbols
from obscli.model.system import Covector, Matrix, Parameter, System
from obscli.numeric.errors import NotComputableError
from obscli.numeric.motion import Motion
from obscli.numeric.program import ROUNDING, Array, Program, Value, constant_error, constant_value, jet
from obscli.numeric.signals import Changed


_UNKNOWN: Final = 1e100


@dataclass(frozen=True, slots=True, eq=False)
class Coefficients:
    """A's moving rows (k, p, n) and H (k, m, n) at k instants, with their rounding errors."""

    A: Array
    H: Array
    A_error: Array
    H_error: Array


class NumericSystem:
    """A system in floating point over an interval of time.

    Parameters
    ----------
    system : the system; parameters take their nominal values
    start, stop : the interval; functions left open follow a sample motion over it, signals their samples
    changed : what is done to the samples of signals first

    Raises
    ------
    NotComputableError
        where a parameter has no value, or no sample motion exists
    """

    def __init__(self, system: System, start: float, stop: float, changed: Changed | None = None) -> None:
        self.system = system
        self.constants = constants_of(system)
        self.motion = Motion(system, self.constants, start, stop, changed) if system.functions else None
        moving = range(system.n) if system.discrete else sorted({i for i, _ in system.A.entries})
        self.moving = np.array(moving, dtype=int)
        self._program = Program([*system.A.entries.values(), *system.H.entries.values()])
        self._orders = derivative_orders([*system.A.entries.values(), *system.H.entries.values()])
        row = {i: k for k, i in enumerate(self.moving)}
        self._places = [(row[i], j) for i, j in system.A.entries]

    @property
    def n(self) -> int:
        """The number of states."""
        return self.system.n

    @property
    def m(self) -> int:
        """The number of outputs."""
        return self.system.m

    @property
    def parts(self) -> tuple[NumericSystem, ...]:
        """Systems that do not act on each other, and together are this one."""
        return (self,)

    @cached_property
    def is_constant(self) -> bool:
        """Whether no coefficient varies with time."""
        moving = {self.system.time} | {one.name for one in self.system.functions}
        return not symbols(*self.system.A.entries.values(), *self.system.H.entries.values()) & moving

    def coefficients(self, t: Array) -> Coefficients:
        """Return A and H at k instants, with their rounding errors.

        Raises
        ------
        NotComputableError
            where an entry is infinite or does not exist at some instant; the text says where
        """
        values = self.values(t, self._orders)
        found = self._program.run_rounded(values, self.errors(values))
        A, H = self._matrices(t, [entry.value for entry in found])
        A_error, H_error = self._placed(len(t), [entry.error for entry in found])
        return Coefficients(A, H, _known(A_error), _known(H_error))

    def matrices(self, t: Array) -> tuple[Array, Array]:
        """Return A's moving rows and H at k instants, without errors: half the work of ``coefficients``."""
        return self._matrices(t, self._program.run(self.values(t, self._orders)))

    def _matrices(self, t: Array, found: Sequence[Value]) -> tuple[Array, Array]:
        A, H = self._placed(len(t), found)
        if not (np.isfinite(A).all() and np.isfinite(H).all()):
            raise NotComputableError(self._where_not_finite(t, found))
        return A, H

    def _placed(self, k: int, found: Sequence[Value]) -> tuple[Array, Array]:
        """Return entries in their places: (k, p, n) and (k, m, n)."""
        A, H = np.zeros((k, len(self.moving), self.n)), np.zeros((k, self.m, self.n))
        count = len(self._places)
        for (i, j), value in zip(self._places, found[:count], strict=True):
            A[:, i, j] = value
        for (i, j), value in zip(self.system.H.entries, found[count:], strict=True):
            H[:, i, j] = value
        return A, H

    def covectors(self, rows: Sequence[Covector], t: Array) -> tuple[Array, Array]:
        """Return linear forms in the states at k instants, and their rounding errors, (k, len(rows), n) each.

        Entries are not finite where they are undefined, or where they need a derivative that jumps from
        sample to sample of a signal: what is said with it does not hold across a sample.
        """
        entries = [entry for row in rows for entry in row.values()]
        values = self._smooth_values(t, entries)
        found = iter(Program(entries).run_rounded(values, self.errors(values)))
        place = {name: j for j, name in enumerate(self.system.state_names)}
        result, errors = np.zeros((2, len(t), len(rows), self.n))
        for k, row in enumerate(rows):
            for name in row:
                entry = next(found)
                result[:, k, place[name]], errors[:, k, place[name]] = entry.value, entry.error
        return result, _known(errors)

    def values(self, t: Array, orders: Mapping[str, int]) -> dict[str, Value]:
        """Return time, parameters and functions at instants, derivatives up to the orders asked for."""
        moving = {} if self.motion is None else self.motion.values(t, orders)
        return {**self.constants, **moving, self.system.time: t}

    def _smooth_values(self, t: Array, entries: Sequence[Expression]) -> dict[str, Value]:
        orders, jumping = derivative_orders(entries), self.jumping(entries)
        smooth = {name: min(order, self._smoothness(name)) for name, order in orders.items()}
        values = self.values(t, {name: max(order, 0) for name, order in smooth.items()})
        gone = {jet(name, order): np.full(len(t), np.nan) for name, order in jumping}
        return {**values, **gone}

    def jumping(self, entries: Sequence[Expression]) -> list[tuple[str, int]]:
        """Return the derivatives of signals in expressions that jump at samples, with their order."""
        orders = dict.fromkeys(symbols(*entries), 0) | derivative_orders(entries)
        return [
            (name, order)
            for name, most in orders.items()
            for order in range(self._smoothness(name) + 1, most + 1)
        ]

    def _smoothness(self, name: str) -> int:
        signals = self.motion.signals if self.motion else None
        return 99 if signals is None or name not in signals.names else signals.smoothness(name)

    def knots(self, start: float, stop: float) -> Array:
        """Return the instants between two others at which a coefficient is not smooth: samples of signals."""
        signals = self.motion.signals if self.motion else None
        return np.empty(0) if signals is None else signals.knots(start, stop)

    def errors(self, values: Mapping[str, Value]) -> dict[str, Value]:
        """Return the errors of the values: of time and parameters by rounding, of functions as sampled."""
        relative = max(ROUNDING, self.motion.error if self.motion else 0.0)
        found = {
            name: relative * np.abs(value) for name, value in values.items() if name not in self.constants
        }
        signals = self.motion.signals if self.motion else None
        sampled = {} if signals is None else signals.errors(values[self.system.time], values)
        return {
            **found,
            **sampled,
            **self._constant_errors,
            self.system.time: ROUNDING * np.abs(values[self.system.time]),
        }

    @cached_property
    def _constant_errors(self) -> dict[str, Value]:
        nominal = {one.name: one.nominal for one in self.system.parameters}
        return {name: constant_error(value) for name, value in nominal.items() if value is not None}

    @cached_property
    def constant_states(self) -> Array:
        """The states whose derivative is identically zero."""
        return np.setdiff1d(np.arange(self.n), self.moving)

    def _where_not_finite(self, t: Array, found: Sequence[Value]) -> str:
        places = [
            *self._matrix_places(self.system.dynamics_name, self.system.A),
            *self._matrix_places("H", self.system.H),
        ]
        for place, value in zip(places, found, strict=True):
            bad = ~np.isfinite(np.broadcast_to(value, t.shape))
            if bad.any():
                at = t[bad][0]
                return (
                    f"{place} does not exist at {self.system.time} = {at:.6g}: "
                    "choose instants that leave it out (--from, --to, or `interval` in the file)"
                )
        return "a coefficient is not finite"

    def _matrix_places(self, name: str, matrix: Matrix) -> Iterable[str]:
        system = self.system
        rows = tuple(one.name for one in system.outputs) if name == "H" else system.state_names
        return (f"{name}[{rows[i]}, {system.state_names[j]}]" for i, j in matrix.entries)


def _known(error: Array) -> Array:
    """Return errors, a large number where they are not finite: nothing is known there."""
    return np.nan_to_num(error, nan=_UNKNOWN, posinf=_UNKNOWN)


def constants_of(system: System) -> dict[str, float]:
    """Return the values of all parameters in use.

    Raises
    ------
    NotComputableError
        naming every parameter without a value
    """
    used = symbols(*system.A.entries.values(), *system.H.entries.values(), *_relations(system))
    missing = [one.name for one in system.parameters if one.nominal is None and one.name in used]
    if missing:
        raise NotComputableError(missing_values(missing))
    return {one.name: _nominal(one) for one in system.parameters if one.nominal is not None}


def missing_values(names: Sequence[str]) -> str:
    """Return the request for values of parameters that have none."""
    what = "parameter without a value" if len(names) == 1 else "parameters without a value"
    given = " ".join(f"--set {name}=…" for name in names[:3])
    return (
        f"{what}: {', '.join(names)}; give {'it' if len(names) == 1 else 'them'} in the file or with {given}"
    )


def _nominal(parameter: Parameter) -> float:
    assert parameter.nominal is not None
    value = constant_value(parameter.nominal, {})
    if not np.isfinite(value):
        raise NotComputableError(f"the value of {parameter.name} is not finite in double precision")
    return value


def _relations(system: System) -> list[Expression]:
    rules = [one.derivative for one in system.functions if one.derivative is not None]
    return [*rules, *(one.expression for one in system.invariants)]


def derivative_orders(roots: Sequence[Expression]) -> dict[str, int]:
    """Return the highest derivative of each function that expressions name."""
    orders: dict[str, int] = {}
    for node in postorder(*roots):
        if isinstance(node, Derivative):
            orders[node.name] = max(orders.get(node.name, 0), node.order)
    return orders
