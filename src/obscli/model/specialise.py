"""A system with some of its parameters or functions replaced by expressions, exactly."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

from obscli.model.expression import Expression, Symbol, TimeDerivative, is_zero, substitute
from obscli.model.system import Covector, Function, Interval, Invariant, Matrix, Noise, Output, System


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
        return _covector(covector, self.expression)

    def system(self) -> System:
        """Return the specialised system."""
        system = self._system
        return replace(
            exchanged(system, self.expression),
            parameters=tuple(p for p in system.parameters if p.name not in self._gone),
            functions=tuple(self._function(f) for f in system.functions if f.name not in self._gone),
        )

    def _function(self, function: Function) -> Function:
        rule = self._rules.get(function.name)
        return replace(function, derivative=None if rule is None else self.expression(rule))


def at_nominal(system: System) -> Specialisation:
    """Replace every parameter that has a nominal value by it, exactly."""
    return Specialisation(system, {p.name: p.nominal for p in system.parameters if p.nominal is not None})


def exchanged(system: System, exchange: Callable[[Expression], Expression]) -> System:
    """Return the system with every coefficient exchanged; rules of functions and claims stay as they are."""
    return replace(
        system,
        invariants=tuple(Invariant(exchange(one.expression), one.place) for one in system.invariants),
        A=_matrix(system.A, exchange),
        H=_matrix(system.H, exchange),
        B=system.B and _matrix(system.B, exchange),
        G=system.G and _matrix(system.G, exchange),
        noise=system.noise and _noise(system.noise, exchange),
        quantities=tuple(
            replace(one, coefficients=_covector(one.coefficients, exchange)) for one in system.quantities
        ),
        outputs=tuple(_output(one, exchange) for one in system.outputs),
        states=tuple(replace(one, scale=one.scale and exchange(one.scale)) for one in system.states),
        prior=_covector(system.prior, exchange),
        interval=system.interval and _interval(system.interval, exchange),
        step=system.step and exchange(system.step),
    )


def _covector(covector: Covector, exchange: Callable[[Expression], Expression]) -> Covector:
    return {state: exchange(entry) for state, entry in covector.items()}


def _output(output: Output, exchange: Callable[[Expression], Expression]) -> Output:
    during = output.during and tuple((exchange(start), exchange(stop)) for start, stop in output.during)
    return replace(output, every=output.every and exchange(output.every), during=during)


def _noise(noise: Noise, exchange: Callable[[Expression], Expression]) -> Noise:
    Q, R, P0 = (one and _matrix(one, exchange, zeros=True) for one in (noise.Q, noise.R, noise.P0))
    signals = _covector(noise.signals, exchange)
    return replace(noise, Q=Q, R=R, P0=P0, step=noise.step and exchange(noise.step), signals=signals)


def _interval(interval: Interval, exchange: Callable[[Expression], Expression]) -> Interval:
    start, stop = (one and exchange(one) for one in (interval.start, interval.stop))
    return replace(interval, start=start, stop=stop)


def _matrix(matrix: Matrix, exchange: Callable[[Expression], Expression], *, zeros: bool = False) -> Matrix:
    """Return the matrix with its entries exchanged; ``zeros``: a zero is an entry, too."""
    entries = {place: exchange(entry) for place, entry in matrix.entries.items()}
    kept = {place: entry for place, entry in entries.items() if zeros or not is_zero(entry)}
    return replace(matrix, entries=kept)
