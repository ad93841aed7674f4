"""Candidates for critical hypersurfaces: where a divisor of the elimination vanishes identically in time.

A divisor is a polynomial in generators that vary in time, with coefficients in those that do not. It
vanishes identically in t only where (a) all its coefficients do: in codimension one, an irreducible factor
of their greatest common divisor, its *content*; or (b) the varying generators become dependent: a rate
becomes zero, or harmonics that occur in the divisor coincide (``collisions``). Roots are freed by norms.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from obscli.exact.errors import JetOverflowError, UndecidedError, UndefinedError
from obscli.exact.field import Element
from obscli.exact.interpreter import Interpreter
from obscli.exact.nonzero import first_nonzero
from obscli.exact.polynomial import common_factor, factored
from obscli.exact.roots import evident_sign, sign_of
from obscli.model.expression import Expression


if TYPE_CHECKING:
    from collections.abc import Iterable

    from flint import fmpz

    from obscli.exact.exact_system import ExactSystem
    from obscli.exact.field import Field
    from obscli.exact.polynomial import Polynomial


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """An irreducible polynomial in constant generators whose zeros are to be tried.

    At a ``collision`` the generators themselves become dependent, so only a rerun can tell.
    """

    polynomial: Polynomial
    origin: Literal["divisor", "denominator", "collision"]


def content_candidates(
    exact: ExactSystem, divisors: Iterable[Polynomial], origin: Literal["divisor", "denominator", "collision"]
) -> dict[str, Candidate]:
    """Return the irreducible factors of the contents in time of some polynomials."""
    found: dict[str, Candidate] = {}
    for divisor in divisors:
        content = time_content(exact.field, exact.field.norm(divisor))
        if content.is_constant():
            continue
        for factor, _ in factored(content)[1]:
            found.setdefault(str(factor), Candidate(factor, origin))
    return found


def time_content(field: Field, polynomial: Polynomial) -> Polynomial:
    """Return the gcd of the coefficients of a polynomial in the generators that vary in time."""
    varying = [k for k in range(len(field.generators)) if field.varies(k)]
    if not varying or polynomial.is_zero():
        return polynomial
    groups: dict[tuple[int, ...], dict[tuple[int, ...], fmpz]] = {}
    for exponents, coefficient in polynomial.terms():
        key = tuple(exponents[k] for k in varying)
        rest = tuple(0 if k in set(varying) else e for k, e in enumerate(exponents))
        groups.setdefault(key, {})[rest] = coefficient
    content = None
    for part in sorted(groups.values(), key=len):
        gathered = field.ctx.from_dict(part)
        content = gathered if content is None else common_factor(content, gathered)
        if content.is_constant():
            break
    assert content is not None
    return content


def has_real_zeros(exact: ExactSystem, factor: Polynomial) -> bool:
    """Whether a factor may vanish on a real hypersurface: not if all its terms have one evident sign.

    Nor if it is a number other than zero, as 1 + cos(1/10). Assumptions about parameters do not count here; a
    zero outside them is reported apart.
    """
    if _is_nonzero_number(exact, factor):
        return False
    return evident_sign(exact.interpreter, factor, assumed=False) is None or _vanishes_at_zero(exact, factor)


def _is_nonzero_number(exact: ExactSystem, factor: Polynomial) -> bool:
    element = Element(exact.field, factor, exact.field.one_polynomial)
    if not exact.interpreter.is_numeric(element):
        return False
    try:
        return first_nonzero(exact.interpreter, [element]) is not None
    except UndecidedError:
        return False


def _vanishes_at_zero(exact: ExactSystem, factor: Polynomial) -> bool:
    """A single generator that is not positive by nature has the hypersurface generator = 0."""
    if len(factor) != 1:
        return False
    generators = exact.field.generators
    used = [k for k, degree in enumerate(factor.degrees()) if degree > 0]
    return not any(generators[k].positive and generators[k].kind != "parameter" for k in used)


def allowed_by_assumptions(exact: ExactSystem, factor: Polynomial) -> bool:
    """Whether a zero of the factor is compatible with ``assume``."""
    if evident_sign(exact.interpreter, factor, assumed=True) is not None:
        return False
    nonzero = {p.name for p in exact.system.parameters if p.assume == "nonzero"}
    used = [k for k, degree in enumerate(factor.degrees()) if degree > 0]
    single = len(used) == 1 and len(factor) == 1
    return not (single and exact.field.generators[used[0]].name in nonzero)


def value_allowed(exact: ExactSystem, name: str, value: Expression) -> bool:
    """Whether a parameter may take a value: not a negative one where it is assumed positive."""
    parameter = next(p for p in exact.system.parameters if p.name == name)
    if parameter.assume != "positive":
        return True
    try:
        interpreter = Interpreter(exact.system, [value])
        element = interpreter.read(value)
        return sign_of(interpreter, element.num * element.den) != -1
    except (UndecidedError, UndefinedError, JetOverflowError):
        return True
