"""Identities among unspecified functions at which the rank drops: f = 0, f constant, and the like.

Tried are: each function zero or constant, sets of up to three of them, all constant, and every irreducible
factor of a divisor that is linear in the highest derivative of a function (of order at most one), such as
f_E f_N' - f_N f_E' = 0 (a fixed direction). A set is reported if no smaller set in it lowers the rank.
"""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING

from obscli.exact.errors import UndecidedError, UndefinedError
from obscli.exact.finding import CriticalValue
from obscli.exact.polynomial import factored, polynomial_coefficients
from obscli.exact.rerun import rerun
from obscli.model.expression import ZERO, Expression, divide, negate, number, symbols
from obscli.model.notation import to_text


if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from obscli.exact.polynomial import Polynomial
    from obscli.exact.prove import Proof

_LARGEST_SET = 3
_MOST_TRIALS = 60


def search_identities(
    proof: Proof, progress: Callable[[str], None]
) -> tuple[list[CriticalValue], tuple[str, ...]]:
    """Return the identities found, and what was not searched."""
    jets = [g for g in proof.exact.field.generators if g.kind == "jet"]
    names = [g.function for g in jets if g.order == 0]
    if not names:
        return [], ()
    found: list[CriticalValue] = []
    dropping: list[frozenset[str]] = []
    trials = 0
    for equations, values, rules in _trials(proof, names):
        if any(smaller <= equations for smaller in dropping):
            continue
        trials += 1
        if trials > _MOST_TRIALS:
            return found, ("further sets of identities among functions",)
        condition = _condition(equations)
        progress(f"critical functions: {condition}")
        value = _try(proof, condition, values, rules)
        if value is not None:
            dropping.append(equations)
            found.append(value)
    return found, ("identities among functions other than f = 0, f constant and factors of the divisors",)


def _try(
    proof: Proof, condition: str, values: dict[str, Expression], rules: dict[str, Expression]
) -> CriticalValue | None:
    try:
        result = rerun(proof, values, rules)
    except UndefinedError:
        return CriticalValue(condition, "undefined", None, (), "A or H does not exist there", functions=True)
    except UndecidedError as error:
        return CriticalValue(condition, "undecided", None, (), str(error), functions=True)
    if result is None:
        return None
    return CriticalValue(condition, "confirmed", result.rank, result.lost, functions=True)


def _trials(
    proof: Proof, names: list[str]
) -> Iterator[tuple[frozenset[str], dict[str, Expression], dict[str, Expression]]]:
    """Yield sets of equations with the substitution and the rules that they amount to."""
    for name in names:
        yield frozenset([name]), {name: ZERO}, {}
    for name in names:
        yield frozenset([f"deriv({name})"]), {}, {name: ZERO}
    yield from _factor_trials(proof)
    for size in range(2, _LARGEST_SET + 1):
        for some in combinations(names, size):
            yield frozenset(some), dict.fromkeys(some, ZERO), {}
            yield frozenset(f"deriv({name})" for name in some), {}, dict.fromkeys(some, ZERO)
    if len(names) > _LARGEST_SET:
        yield frozenset(f"deriv({name})" for name in names), {}, dict.fromkeys(names, ZERO)


def _factor_trials(
    proof: Proof,
) -> Iterator[tuple[frozenset[str], dict[str, Expression], dict[str, Expression]]]:
    field = proof.exact.field
    for factor in _factors(proof).values():
        jets = [
            k for k, degree in enumerate(factor.degrees()) if degree > 0 and field.generators[k].kind == "jet"
        ]
        if not jets or len(factor) < 2:
            continue
        top = max(jets, key=lambda k: field.generators[k].order)
        generator = field.generators[top]
        if generator.order > 1 or factor.degrees()[top] != 1:
            continue
        below, above = (
            proof.exact.interpreter.expression(c) for c in polynomial_coefficients(factor, top)[::-1]
        )
        value = negate(divide(above, below))
        if generator.order == 0 and generator.function in symbols(value):
            continue
        equation = frozenset([to_text(proof.restorer.polynomial(factor))])
        if generator.order == 0:
            yield equation, {generator.function: value}, {}
        else:
            yield equation, {}, {generator.function: value}


def _factors(proof: Proof) -> dict[str, Polynomial]:
    found: dict[str, Polynomial] = {}
    for divisor in proof.flag.divisors:
        for factor, _ in factored(proof.exact.field.norm(divisor))[1]:
            found.setdefault(str(factor), factor)
    return found


def _condition(equations: frozenset[str]) -> str:
    return " = ".join([*sorted(equations), to_text(number(0))])
