"""How far the file's values are from a condition on which the rank is lower: near-misses.

A condition p = c(other parameters) that does not hold at the values is missed by

    |p − c| / max(|p|, |c|)

found in ball arithmetic, so that a difference in the last of many digits counts as exactly as any other.
Where c is zero that is 1 whatever p is. Then p is held against what it can be compared with, and nothing is
said where there is nothing:

    the largest other parameter of the same ``unit``;
    where p times a number is a rate of the system, that rate against the fastest other one

Rates are the roots that belong to the outputs of a time-invariant system (of an irreducible factor of μ, see
``annihilator``, their geometric mean), and the constant rates of angles and exponents of one that varies.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from flint import arb

from obscli.exact.annihilator import annihilator
from obscli.exact.ball import BallPoint, OutsideDomainError, precision
from obscli.exact.errors import JetOverflowError, UndecidedError
from obscli.exact.finding import CriticalSearch, NearMiss
from obscli.exact.hidden_dynamics import occurring
from obscli.exact.spectrum import factors
from obscli.model.expression import Symbol
from obscli.model.specialise import at_nominal


if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from obscli.exact.field import Element
    from obscli.exact.finding import CriticalValue, Measure
    from obscli.exact.prove import Proof
    from obscli.model.expression import Expression

#: A condition that is missed by less than this is nearly met.
NEARLY: Final = 1e-6
_BITS: Final = 1024


def near_misses(proof: Proof, critical: CriticalSearch, rank: int) -> tuple[NearMiss, ...]:
    """Return the conditions nearly met on which the rank is lower than at the file's values, nearest first.

    Parameters
    ----------
    proof : the system
    critical : critical values found, on which the rank is proved
    rank : at the file's values
    """
    found = []
    with precision(_BITS, 1):
        values = _Values(proof)
        for one in critical.values:
            if one.kind in {"confirmed", "excluded"} and one.rank is not None and one.rank < rank:
                found += _missed(values, one, one.rank)
    return tuple(sorted(found, key=lambda one: one.distance))


def _missed(values: _Values, one: CriticalValue, rank: int) -> list[NearMiss]:
    """Return how far the nearest of the values of a condition is, if that is near."""
    known = [miss for solution in one.values for miss in values.distances(solution)]
    if any(distance == 0 for distance, _ in known):
        return []
    distance, measure = min(known, default=(NEARLY, "value"))
    return [NearMiss(one.condition, rank, distance, measure)] if distance < NEARLY else []


class _Values:
    """The file's values in ball arithmetic; use inside ``precision``."""

    def __init__(self, proof: Proof) -> None:
        system = proof.exact.system
        self._proof = proof
        self._nominal = at_nominal(system)
        self._point = BallPoint(self._nominal.system(), {}, 1)
        self._parameters = {parameter.name: parameter for parameter in system.parameters}
        self._rates: tuple[tuple[Element, int], ...] | None = None

    def distances(self, solution: Mapping[str, Expression]) -> Iterator[tuple[float, Measure]]:
        """Yield how far a parameter is from its value on a condition, and of what: 0 where it is met."""
        for name, expression in solution.items():
            if name not in self._parameters:
                continue
            p, c = self._ball(Symbol(name)), self._ball(expression)
            if p is None or c is None:
                continue
            difference = abs(p - c)
            if difference.contains(0):
                yield 0.0, "value"
            elif not (p.contains(0) or c.contains(0)):
                yield _float(difference / abs(p).max(abs(c))), "value"
            elif not p.contains(0):
                yield from self._small(name, difference)

    def _small(self, name: str, size: arb) -> Iterator[tuple[float, Measure]]:
        """Yield how small a parameter is against what it can be compared with, if anything."""
        unit = self._parameters[name].unit
        alike = [
            abs(ball)
            for other, parameter in self._parameters.items()
            if unit and other != name and parameter.unit == unit
            if (ball := self._ball(Symbol(other))) is not None
        ]
        if alike and (largest := max(alike, key=_float)) > 0:
            yield _float(size / largest), "unit"
            return
        if self._rates is None:
            self._rates = tuple(_rates(self._proof))
        own = [_is_multiple(self._proof, rate, name) for rate in self._rates]
        mine = self._fastest(rate for rate, is_own in zip(self._rates, own, strict=True) if is_own)
        others = self._fastest(rate for rate, is_own in zip(self._rates, own, strict=True) if not is_own)
        if mine is not None and others is not None:
            yield _float(mine / others), "rate"

    def _fastest(self, rates: Iterable[tuple[Element, int]]) -> arb | None:
        sizes = []
        for element, k in rates:
            ball = self._ball(self._proof.exact.interpreter.element_expression(element))
            if ball is not None and not ball.contains(0):
                sizes.append(abs(ball).root(k))
        return max(sizes, key=_float, default=None)

    def _ball(self, expression: Expression) -> arb | None:
        try:
            ball: arb = self._point.value(self._nominal.expression(expression))[0]
        except (OutsideDomainError, KeyError):
            return None
        return ball


def _rates(proof: Proof) -> Iterator[tuple[Element, int]]:
    """Yield rates as pairs: an element and the number of equal factors that make it."""
    if proof.exact.varies:
        yield from ((rate, 1) for rate in _rates_of_generators(proof))
        return
    try:
        found = factors(proof.exact.field, annihilator(proof.exact).coefficients)
    except (UndecidedError, JetOverflowError):
        return
    yield from ((one.coefficients[0], one.degree) for one in found if one.coefficients[0])


def _rates_of_generators(proof: Proof) -> Iterator[Element]:
    """Yield the constant derivatives of base angles and exponents."""
    field, interpreter = proof.exact.field, proof.exact.interpreter
    for generator in field.generators:
        if generator.kind in {"angle", "exponential"} and generator.argument is not None:
            rate = field.derive(interpreter.read(generator.argument))
            if rate and not any(field.varies(k) for k in occurring(rate)):
                yield rate


def _is_multiple(proof: Proof, rate: tuple[Element, int], name: str) -> bool:
    """Whether a rate is a rational multiple of a parameter."""
    element, k = rate
    field = proof.exact.field
    if name not in field.index or max(len(element.num), len(element.den)) > 1:
        return False
    ratio = element / field.generator(name) ** k
    return ratio.rational is not None


def _float(ball: arb) -> float:
    return float(ball.mid())
