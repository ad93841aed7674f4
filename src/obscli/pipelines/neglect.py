"""What an exact substitution changes: the system before it compared with the system after it."""

from __future__ import annotations

from dataclasses import replace

from obscli.exact import analysis as engine
from obscli.exact.finding import Analysis, Neglect
from obscli.model.covector import parse_scalar
from obscli.model.specialise import Specialisation
from obscli.model.system import System


def compared(before: Analysis, after: Analysis, substitution: str) -> Neglect:
    """Return the ranks before and after, and the combinations lost and gained.

    A combination of the system before is lost where, the substitution made in it, it is no combination of
    the system after; it is reported as it was before. One of the system after is gained where it was none
    before, unless it merely is one of those before, of the same states, with the substitution made in it.

    Raises
    ------
    UndecidedError, UndefinedError
        where some coefficient cannot be compared with zero, or does not exist after the substitution.
    """
    gone = _free_names(before.system) - _free_names(after.system)
    values = {name: parse_scalar(after.system, name, "--fix") for name in sorted(gone)}
    special = Specialisation(before.system, values)
    images = tuple(
        replace(one, coefficients=special.covector(one.coefficients)) for one in before.combinations
    )
    found = engine.compare(replace(before, combinations=images), after, substitution)
    originals = {
        id(image.coefficients): one.coefficients
        for image, one in zip(images, before.combinations, strict=True)
    }
    lost = tuple(originals.get(id(covector), covector) for covector in found.lost)
    directions = tuple(special.covector(direction) for direction in before.unobservable)
    known = engine.contained(replace(before, unobservable=directions), list(found.gained))
    supports = {frozenset(one.coefficients) for one in before.combinations}
    gained = tuple(
        covector
        for covector, is_image in zip(found.gained, known, strict=True)
        if not (is_image and frozenset(covector) in supports)
    )
    return replace(found, lost=lost, gained=gained)


def _free_names(system: System) -> set[str]:
    return {one.name for one in system.parameters} | {one.name for one in system.functions}
