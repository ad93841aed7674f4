"""Constants that may become related to the rest of the model on hypersurfaces that no factor shows.

sin(p) and p both vanish at p = 0, where no polynomial in p and tan(p/2) does. That cannot happen where
each such constant, sin(phi + q), exp(a), log(b), has a parameter of its own: one that enters its argument
linearly, with a number as factor, and occurs nowhere else. Then parameters and constants are the same
coordinates written twice, and what has codimension two in the one has it in the other.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from obscli.exact.field import Element
from obscli.exact.polynomial import polynomial_coefficients


if TYPE_CHECKING:
    from collections.abc import Sequence

    from obscli.exact.exact_system import ExactSystem

_KINDS = frozenset({"angle", "exponential", "primitive"})


def entangled_constants(exact: ExactSystem) -> tuple[int, ...]:
    """Return the constant angles, exponentials and primitives without a parameter of their own, by index."""
    field = exact.field
    constants = [
        k
        for k, g in enumerate(field.generators)
        if g.kind in _KINDS and not g.numeric and not field.varies(k)
    ]
    if not constants:
        return ()
    places = _places(exact)
    return tuple(k for k in constants if not _has_own_parameter(exact, k, places))


def _places(exact: ExactSystem) -> list[set[int]]:
    """Return the generators that occur in A and H together, and in each argument, relation and rule."""
    interpreter = exact.interpreter
    entries = [e for row in (*exact.A, *exact.H) for e in row.values()]
    rules = [interpreter.read(rule) for rule in interpreter.rules.values()]
    parts: list[Sequence[Element]] = [entries, rules]
    for generator in exact.field.generators:
        if generator.kind == "root":
            parts.append([interpreter.read(coefficient) for coefficient in generator.relation])
        elif generator.argument is not None:
            parts.append([interpreter.read(generator.argument)])
    return [_generators(part) for part in parts]


def _generators(elements: Sequence[Element]) -> set[int]:
    degrees = [p.degrees() for e in elements for p in (e.num, e.den)]
    return {k for row in degrees for k, degree in enumerate(row) if degree > 0}


def _has_own_parameter(exact: ExactSystem, k: int, places: Sequence[set[int]]) -> bool:
    argument = exact.field.generators[k].argument
    assert argument is not None
    element = exact.interpreter.read(argument)
    return any(
        exact.field.generators[j].kind == "parameter"
        and sum(j in place for place in places) == 1
        and _is_linear(exact, element, j)
        for j in _generators([element])
    )


def _is_linear(exact: ExactSystem, element: Element, j: int) -> bool:
    """Whether a generator enters an element with degree one and a number as factor."""
    if element.num.degrees()[j] != 1:
        return False
    factor = polynomial_coefficients(element.num, j)[1]
    return exact.interpreter.is_numeric(Element(exact.field, factor, element.den))
