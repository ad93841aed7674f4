"""A system with some of its parameters or functions replaced by expressions, exactly."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

from obscli.model.expression import Expression, Symbol, TimeDerivative, is_zero, substitute
from obscli.model.system import Covector, Function, Interval, Invariant, Matrix, Noise, System


class Specialisation:
    """Replaces parameters and functions of a system, and gives functions a rule f' = F.

    Parameters
    ----------
    system : the system whose names are used
    values : expression by name of parameter or function; the name is free no more
    rules : functions that are to satisfy f' = rule from now on
    """

    def __init__(
        self,
        system: System,
        values: Mapping[str, Expression],
        rules: Mapping[str, Expression] | None = None,
    ) -> None:
        self._system = system
        self._rules = {f.name: f.derivative for f in system.functions if f.derivative is not None}
        self._rules.update(rules or {})
        free = frozenset(f.name for f in system.functions) - self._rules.keys()
        self._derive = TimeDerivative(system.time, self._rules, free)
        new = rules or {}
        self._values = {**values, **{name: Symbol(name) for name in new if name not in values}}
        self._gone = frozenset(values)

    def expression(self, expression: Expression) -> Expression:
        """Return the expression with the replacements made."""
        return substitute(expression, self._values, self._derive)

    def covector(self, covector: Covector) -> Covector:
        """Return a linear form with the replacements made."""
        return {state: self.expression(entry) for state, entry in covector.items()}

    def system(self) -> System:
        """Return the specialised system."""
        system = self._system
        return replace(
            system,
            parameters=tuple(p for p in system.parameters if p.name not in self._gone),
            functions=tuple(self._function(f) for f in system.functions if f.name not in self._gone),
            invariants=tuple(Invariant(self.expression(i.expression), i.place) for i in system.invariants),
            A=_matrix(system.A, self.expression),
            H=_matrix(system.H, self.expression),
            B=system.B and _matrix(system.B, self.expression),
            G=system.G and _matrix(system.G, self.expression),
            noise=self._noise(system.noise),
            quantities=tuple(
                replace(q, coefficients=self.covector(q.coefficients)) for q in system.quantities
            ),
            states=tuple(replace(s, scale=self._optional(s.scale)) for s in system.states),
            prior=self.covector(system.prior),
            interval=self._interval(system.interval),
        )

    def _optional(self, expression: Expression | None) -> Expression | None:
        return None if expression is None else self.expression(expression)

    def _noise(self, noise: Noise | None) -> Noise | None:
        if noise is None:
            return None
        Q, R, P0 = (one and _matrix(one, self.expression, zeros=True) for one in (noise.Q, noise.R, noise.P0))
        return replace(noise, Q=Q, R=R, P0=P0, step=self._optional(noise.step))

    def _interval(self, interval: Interval | None) -> Interval | None:
        if interval is None:
            return None
        return replace(interval, start=self._optional(interval.start), stop=self._optional(interval.stop))

    def _function(self, function: Function) -> Function:
        rule = self._rules.get(function.name)
        return replace(function, derivative=None if rule is None else self.expression(rule))


def at_nominal(system: System) -> Specialisation:
    """Replace every parameter that has a nominal value by it, exactly."""
    return Specialisation(system, {p.name: p.nominal for p in system.parameters if p.nominal is not None})


def _matrix(matrix: Matrix, exchange: Callable[[Expression], Expression], *, zeros: bool = False) -> Matrix:
    """Return the matrix with its entries exchanged; ``zeros``: a zero is an entry, too."""
    entries = {place: exchange(entry) for place, entry in matrix.entries.items()}
    kept = {place: entry for place, entry in entries.items() if zeros or not is_zero(entry)}
    return replace(matrix, entries=kept)
