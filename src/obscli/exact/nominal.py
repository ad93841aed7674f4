"""The exact rank at the file's parameter values, and why it differs from the generic one.

At special values the rank can only drop: a minor that vanishes identically vanishes at the values. So
where the minor that proves the generic rank is nonzero at the values too, the rank is the generic one;
otherwise the specialised system is analysed anew.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from obscli.exact.distance import near_misses
from obscli.exact.errors import JetOverflowError, UndecidedError, UndefinedError
from obscli.exact.exact_system import read_system
from obscli.exact.finding import AtValues, CriticalSearch
from obscli.exact.interpreter import Interpreter
from obscli.exact.lower import prove_lower_bound
from obscli.exact.prove import Proof, certificate, prove, prove_read
from obscli.exact.saturation import rank_modulo_a_prime
from obscli.model.expression import Symbol
from obscli.model.notation import to_text
from obscli.model.specialise import Specialisation, at_nominal


if TYPE_CHECKING:
    from collections.abc import Mapping

    from obscli.model.expression import Expression
    from obscli.model.system import Parameter, System


def rank_at_values(proof: Proof, critical: CriticalSearch | None) -> AtValues:
    """Return the proved rank at the nominal values of the parameters, and what they nearly meet."""
    system = proof.exact.system
    missing = [p.name for p in _used(proof) if p.nominal is None]
    if missing:
        return AtValues(None, (), f"no value for {', '.join(missing)}; give one with --set {missing[0]}=…")
    if not _used(proof):
        return AtValues(proof.rank, ())
    try:
        found = _rank(proof, at_nominal(system).system(), critical)
    except UndefinedError as error:
        return AtValues(None, (), f"at the file's values a coefficient does not exist: {error}")
    except UndecidedError as error:
        return AtValues(None, (), str(error))
    if critical is None or found.rank is None:
        return found
    return replace(found, nearly=near_misses(proof, critical, found.rank))


def _used(proof: Proof) -> list[Parameter]:
    return [p for p in proof.exact.system.parameters if p.name in proof.exact.field.index]


def _rank(proof: Proof, special: System, critical: CriticalSearch | None) -> AtValues:
    columns = list(proof.flag.rows)
    interpreter = read_system(special).interpreter
    try:
        prove_lower_bound(special, interpreter, proof.saturation.rows, columns, patient=False)
    except UndecidedError:
        rerun = prove(special, range(special.n))
        because = () if rerun.rank == proof.rank else _because(proof, rerun.rank, critical)
        return AtValues(rerun.rank, because, certificate=certificate(rerun))
    return AtValues(proof.rank, ())


def _because(proof: Proof, rank: int, critical: CriticalSearch | None) -> tuple[str, ...]:
    """Name the critical conditions that hold at the values, else the fewest values that lower the rank."""
    if critical is not None:
        nominal = at_nominal(proof.exact.system)
        found = tuple(
            value.condition
            for value in critical.values
            if value.zero is not None and value.rank is not None and _vanishes(nominal, value.zero)
        )
        if found:
            return found
    return _fewest_values(proof, rank)


def vanishes_at_nominal(system: System, zero: Expression) -> bool:
    """Whether an expression in the parameters of a system is zero at their nominal values."""
    return _vanishes(at_nominal(system), zero)


def _vanishes(nominal: Specialisation, zero: Expression) -> bool:
    expression = nominal.expression(zero)
    try:
        return not Interpreter(nominal.system(), [expression]).read(expression)
    except (UndecidedError, UndefinedError, JetOverflowError):
        return False


def _fewest_values(proof: Proof, rank: int) -> tuple[str, ...]:
    """Free the parameters one by one; those whose freeing restores the rank are the reason."""
    system = proof.exact.system
    fixed = {p.name: p.nominal for p in _used(proof) if p.nominal is not None}
    for name in list(fixed):
        rest = {other: value for other, value in fixed.items() if other != name}
        if _rank_is(system, rest, rank):
            fixed = rest
    if len(fixed) == 2:  # an equality that lowers the rank lets all other values be free
        first, second = fixed
        equal = {second: Symbol(first)}
        if to_text(fixed[first]) == to_text(fixed[second]) and _rank_is(system, equal, rank):
            return (f"{second} = {first}",)
    return tuple(f"{name} = {to_text(value)}" for name, value in fixed.items())


def _rank_is(system: System, values: Mapping[str, Expression], rank: int) -> bool:
    """Whether that is proved; a higher rank shows modulo a prime, with no elimination."""
    try:
        exact = read_system(Specialisation(system, values).system())
        return rank_modulo_a_prime(exact) <= rank and prove_read(exact, range(system.n), ()).rank == rank
    except (UndecidedError, UndefinedError):
        return False
