"""A system frozen at an instant: A, H (B, G) taken as constant, as they are at t = T.

    x' = A(T) x,  y = H(T) x

A function of time f becomes a constant, f(T), and so does each of its derivatives that occurs; both stay open
(f' = 0 from now on), and satisfy at T what the relations of the file and their derivatives say of them. What
is observable of the frozen system says nothing of the one that moves: textbook/frozen_observable.yaml.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from obscli.core.place import ModelError, Problem
from obscli.model.expression import (
    ZERO,
    Derivative,
    Expression,
    Symbol,
    TimeDerivative,
    children,
    postorder,
    rebuild,
    symbols,
)
from obscli.model.form import Form, Impossible, exact
from obscli.model.scope import Absent, Scope
from obscli.model.specialise import exchanged
from obscli.model.system import Function, Invariant, System
from obscli.model.tensor import Tensor
from obscli.model.written import to_text


def frozen_at(system: System, instant: Expression) -> System:
    """Return the system with everything as it is at one instant.

    Parameters
    ----------
    instant : T, free of time and functions

    Raises
    ------
    ValueError
        the instant moves
    ModelError
        some coefficient does not exist at the instant; the first of each matrix, with its place
    """
    moving = sorted(symbols(instant) & {system.time, *(one.name for one in system.functions)})
    if moving:
        raise ValueError(f"an instant is constant, and '{moving[0]}' is not")
    at = _Instant(system, instant)
    problems = [one for name in "AHBG" for one in _nowhere(system, name, at)]
    if problems:
        raise ModelError(problems)
    scope = None if system.scope is None else _scope(system.scope, at)
    try:
        found = exchanged(system, at)
        relations = _relations(system, at)
    except Impossible as error:
        message = f"the system does not exist at {at.text()}: {error.message}"
        raise ModelError([Problem(system.states[0].place, "", message)]) from None
    invariants = (*found.invariants, *relations)
    return replace(
        found, functions=tuple(at.functions()), invariants=invariants, claims=(), scope=scope, signals=()
    )


class _Instant:
    """Exchanges expressions for what they are at the instant, exactly.

    ``derivatives``: the names of the constants that stand for derivatives of functions.
    """

    def __init__(self, system: System, instant: Expression) -> None:
        self._system = system
        self._instant = instant
        self._memo: dict[int, tuple[Expression, Expression]] = {}
        self.derivatives: dict[tuple[str, int], str] = {}
        self._taken = {system.time, *system.state_names, *(one.name for one in system.parameters)}
        self._taken |= {one.name for one in system.functions} | set(
            system.scope.values if system.scope else ()
        )

    def __call__(self, root: Expression) -> Expression:
        for node in postorder(root, known=self._memo):
            self._memo[id(node)] = (node, self._exchanged(node))
        return self._memo[id(root)][1]

    def _exchanged(self, node: Expression) -> Expression:
        match node:
            case Symbol(name) if name == self._system.time:
                return self._instant
            case Derivative(name, order):
                return Symbol(self._name(name, order))
        parts = children(node)
        new = tuple(self._memo[id(part)][1] for part in parts)
        same = all(one is other for one, other in zip(parts, new, strict=True))
        return node if same else exact(rebuild(node, new))

    def _name(self, function: str, order: int) -> str:
        """Return the name of the constant for a derivative: ``deriv_f``, ``deriv2_f``."""
        key = function, order
        if key not in self.derivatives:
            name = f"deriv{order if order > 1 else ''}_{function}"
            while name in self._taken:
                name += "_"
            self._taken.add(name)
            self.derivatives[key] = name
        return self.derivatives[key]

    def text(self) -> str:
        """Return the instant in words: ``t = 3``."""
        return f"{self._system.time} = {to_text(self._instant)}"

    def functions(self) -> Iterator[Function]:
        """Yield the functions, which are constant now, and then those for derivatives."""
        places = {one.name: one.place for one in self._system.functions}
        yield from (Function(name, place, ZERO) for name, place in places.items())
        for (function, _), name in self.derivatives.items():
            yield Function(name, places[function], ZERO)


def _nowhere(system: System, name: str, at: _Instant) -> Iterator[Problem]:
    """Yield the first entry of a matrix that does not exist at the instant."""
    matrix = getattr(system, name)
    for key, entry in sorted(matrix.entries.items()) if matrix else ():
        try:
            at(entry)
        except Impossible as error:
            place = matrix.places.get(key, system.states[0].place)
            message = f"a coefficient of {name} does not exist at {at.text()}: {error.message}"
            yield Problem(place, "", message, "freeze the system at another instant")
            return


def _relations(system: System, at: _Instant) -> list[Invariant]:
    """Return the derivatives of the relations, up to the order of the derivatives that occur in them."""
    rules = {one.name: one.derivative for one in system.functions if one.derivative is not None}
    free = frozenset(one.name for one in system.functions) - rules.keys()
    derive = TimeDerivative(system.time, rules, free)
    found = []
    occurring = dict(at.derivatives)
    for one in system.invariants:
        names, relation = symbols(one.expression), one.expression
        for _ in range(max((order for name, order in occurring if name in names), default=0)):
            relation = derive(relation)
            found.append(Invariant(at(relation), one.place))
    return found


def _scope(scope: Scope, at: _Instant) -> Scope:
    """Return the names of the file with their values at the instant, for expressions given later."""
    values, absent = dict(scope.values), dict(scope.absent)
    for name, tensor in scope.values.items():
        try:
            values[name] = Tensor(tensor.shape, tuple(_form(form, at) for form in tensor.entries))
        except Impossible as error:
            del values[name]
            absent[name] = Absent(f"'{name}' does not exist at {at.text()}: {error.message}")
    values.update({name: Tensor((), (Form(Symbol(name)),)) for name in at.derivatives.values()})
    return replace(scope, values=values, absent=absent, derive=lambda _: ZERO)


def _form(form: Form, at: _Instant) -> Form:
    return Form(at(form.constant), {name: at(node) for name, node in form.linear.items()}, form.held)
