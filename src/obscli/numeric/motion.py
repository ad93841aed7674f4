"""The motion of a system: signals as sampled, and a sample motion for the functions that a model leaves open.

The exact side proves its result for generic functions; the numerical side has to take some. A function
without a rule becomes a sum of tones with fixed random amplitudes, rates and phases,

    f(t) = c + Σ_k a_k sin(ν_k (t − t0) + φ_k),    c > Σ |a_k|  (so that 1/f, log f and √f exist);

functions tied by relations are moved onto them at every instant; a function with a rule f' = F starts from
random values that satisfy the relations and follows the rule. A signal is what its file says, whatever rule
or relation the model gives it beside.
"""

from __future__ import annotations

import math
import random
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from obscli.model.expression import Expression, symbols
from obscli.model.system import System
from obscli.numeric.constraint import RESIDUAL, onto_relations
from obscli.numeric.errors import NotComputableError
from obscli.numeric.program import Array, Program, Value, jet
from obscli.numeric.rule import Solution, solve_rules
from obscli.numeric.signals import Changed, Signals


_SEED: Final = 20181
_TONES: Final = ((0.5, 1.3), (0.4, 2.7), (0.3, 4.1))  # amplitude, periods in the interval
_STRAYED: Final = 1e-8


@dataclass(frozen=True, slots=True)
class Tones:
    """c + Σ a sin(ν (t − t0) + φ): offset c, and (a, ν, φ) of each tone."""

    offset: float
    start: float
    tones: tuple[tuple[float, float, float], ...]

    def value(self, t: Array, order: int) -> Array:
        """Return the derivative of the given order."""
        total = np.full(np.shape(t), 0.0 if order else self.offset)
        for a, rate, phase in self.tones:
            total += a * rate**order * np.sin(rate * (t - self.start) + phase + order * math.pi / 2)
        return total


class Motion:
    """The functions of a system along one sample motion.

    Parameters
    ----------
    system : functions, rules and relations
    constants : values of the parameters
    start, stop : the interval of time the motion is for
    changed : what is done to the samples of signals first

    Raises
    ------
    NotComputableError
        where no motion satisfies the relations, or the rules run away, or signals are not as the model says
    """

    def __init__(
        self,
        system: System,
        constants: Mapping[str, float],
        start: float,
        stop: float,
        changed: Changed | None = None,
    ) -> None:
        self._system = system
        self._constants = constants
        self.signals = Signals(system, start, stop, changed) if system.sampled else None
        sampled = self.signals.names if self.signals else frozenset[str]()
        left_open = [f for f in system.functions if f.name not in sampled]
        rules = {f.name: f.derivative for f in left_open if f.derivative is not None}
        self._tones = _sampled([f.name for f in left_open if f.name not in rules], start, stop)
        named = self._tones.keys() | rules.keys()
        self._relations = [one.expression for one in system.invariants if symbols(one.expression) & named]
        tied = frozenset[str]().union(*(symbols(one) for one in self._relations))
        about_ruled = [one for one in self._relations if symbols(one) & rules.keys()]
        about_tones = [
            one for one in self._relations if one not in about_ruled and symbols(one) & self._tones.keys()
        ]
        self._projection = Program(about_tones) if about_tones else None
        self._projected = [name for name in self._tones if name in tied and about_tones]
        self._solution = self._solved(rules, about_ruled, start, stop) if rules else None
        self._check(start, stop)

    @property
    def names(self) -> tuple[str, ...]:
        """The functions that a sample motion was taken for, in the order of the model."""
        given = self.signals.names if self.signals else ()
        return tuple(f.name for f in self._system.functions if f.name not in given)

    @property
    def rate(self) -> float:
        """The fastest rate of the tones, 0 where there are none."""
        return max((rate for one in self._tones.values() for _, rate, _ in one.tones), default=0.0)

    @property
    def error(self) -> float:
        """The relative error of functions that follow rules or relations; that of tones is rounding."""
        if self._solution is not None:
            return self._solution.error
        return RESIDUAL if self._projected else 0.0

    def values(self, t: Array, orders: Mapping[str, int]) -> dict[str, Value]:
        """Return the functions at the instants, and their derivatives up to the orders asked for."""
        found = self._free(t)
        if self._solution is not None:
            found |= self._solution.values(t)
        sampled: frozenset[str] = frozenset()
        if self.signals is not None:
            sampled = self.signals.names
            found |= self.signals.values(t, orders)
        for name, top in orders.items():
            if name in sampled:
                continue
            if top and name not in self._tones:
                raise NotComputableError(f"a derivative of {name}, which has a rule, is not sampled")
            if top and name in self._projected:
                raise NotComputableError(
                    f"derivatives of {name}, which satisfies a relation, are not sampled"
                )
            found |= {jet(name, k): self._tones[name].value(t, k) for k in range(1, top + 1)}
        return found

    def _free(self, t: Array) -> dict[str, Value]:
        found: dict[str, Value] = {name: one.value(t, 0) for name, one in self._tones.items()}
        if self.signals is not None:
            found |= self.signals.values(t, {})
        if self._projection is None:
            return found
        start = np.array([found[name] for name in self._projected]).reshape(len(self._projected), len(t))
        known = {**self._constants, **found, self._system.time: t}
        moved = onto_relations(self._projection, self._projected, start, known)
        return {**found, **dict(zip(self._projected, moved, strict=True))}

    def _solved(
        self, rules: Mapping[str, Expression], relations: list[Expression], start: float, stop: float
    ) -> Solution:
        names = list(rules)
        first = np.array([start])
        source = random.Random(_SEED)  # noqa: S311 - a sample, no secret
        guess = np.array([[source.uniform(0.3, 1.0)] for _ in names])
        if relations:
            known = {**self._constants, **self._free(first), self._system.time: first}
            guess = onto_relations(Program(relations), names, guess, known)

        def given(t: Array) -> dict[str, Value]:
            return {**self._constants, **self._free(t), self._system.time: t}

        return solve_rules(rules, guess[:, 0], given, start, stop)

    def _check(self, start: float, stop: float) -> None:
        """Make sure that the relations hold along the motion, not only where it starts."""
        if not self._relations:
            return
        t = np.linspace(start, stop, 33)
        values = {**self._constants, **self.values(t, {}), self._system.time: t}
        for one in Program(self._relations).run(values):
            if not np.abs(one).max() <= _STRAYED:
                raise NotComputableError(
                    "the relations of the file's functions do not hold along a sample motion: "
                    "the rules do not keep them, or the file's values contradict them"
                )


def _sampled(names: list[str], start: float, stop: float) -> dict[str, Tones]:
    source = random.Random(_SEED)  # noqa: S311 - a sample, no secret
    found = {}
    for name in names:
        tones = tuple(
            (
                a * source.uniform(0.7, 1.0),
                2 * math.pi * periods * source.uniform(0.8, 1.2) / (stop - start),
                source.uniform(0, 2 * math.pi),
            )
            for a, periods in _TONES
        )
        found[name] = Tones(1.5 * source.uniform(0.9, 1.1), start, tones)
    return found
