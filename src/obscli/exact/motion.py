"""Which motion a state needs: the functions of time that may not all be zero, or not all be constant.

Tried are sets of up to three functions, single ones and vectors first, each set zero at all times or
constant. Where the rank of the system is lower then, the states and quantities that are observable for
generic functions and not then need one of the set to be different from zero, or to vary. A set is reported
if no smaller set in it costs the same state. Ranks are compared modulo a prime; a lower one is proved by
analysing the special system anew.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final, Literal, TypeAlias

from obscli.exact.analysis import analyze
from obscli.exact.errors import UndecidedError, UndefinedError
from obscli.exact.finding import Analysis
from obscli.exact.prove import Proof, prove
from obscli.exact.rerun import rerun
from obscli.exact.why import LIGHT
from obscli.model.expression import ZERO, Expression
from obscli.model.specialise import Specialisation
from obscli.model.system import System


#: What the functions of a set may not all be.
Kind: TypeAlias = Literal["zero", "constant"]

LARGEST_SET: Final = 3
_MOST_TRIALS: Final = 80


@dataclass(frozen=True, slots=True)
class Need:
    """A state or quantity that is lost where all of some functions are zero, or constant; ``rank``: then."""

    target: str
    functions: tuple[str, ...]
    kind: Kind
    rank: int


@dataclass(frozen=True, slots=True)
class MotionNeeds:
    """What was found, and what was not tried; ``reason``: why nothing was."""

    needs: tuple[Need, ...]
    rank: int | None = None
    tried: int = 0
    cut: bool = False
    reason: str = ""


def motion_needs(system: System, progress: Callable[[str], None] = lambda _: None) -> MotionNeeds:
    """Return which functions the states and quantities of a system need."""
    names = [one.name for one in system.functions if one.derivative is None]
    if not names:
        return MotionNeeds((), reason="no function of time is left open")
    generic = analyze(system, LIGHT)
    if not isinstance(generic, Analysis):
        return MotionNeeds((), reason=generic.reason)
    try:
        proof = prove(system, range(system.n), _extra(system))
    except (UndecidedError, UndefinedError) as error:
        return MotionNeeds((), reason=str(error))
    seen = _observable(generic)
    found: list[Need] = []
    tried = 0
    for kind, some in _trials(names):
        if tried == _MOST_TRIALS:
            return MotionNeeds(_smallest(found), generic.rank, tried, cut=True)
        tried += 1
        progress(f"motion: {', '.join(some)} {kind}")
        found += _lost(proof, seen, some, kind, found)
    return MotionNeeds(_smallest(found), generic.rank, tried)


def _extra(system: System) -> list[Expression]:
    return [entry for one in system.quantities for entry in one.coefficients.values()]


def _trials(names: Sequence[str]) -> Iterator[tuple[Kind, tuple[str, ...]]]:
    """Yield single functions, then whole vectors, then all other small sets."""
    vectors = _vectors(names)
    kinds: tuple[Kind, ...] = ("zero", "constant")
    for size in range(1, LARGEST_SET + 1):
        sets = [some for some in combinations(names, size) if some not in vectors]
        yield from ((kind, some) for kind in kinds for some in sets)
        if size == 1:
            yield from ((kind, some) for kind in kinds for some in vectors)


def _vectors(names: Sequence[str]) -> list[tuple[str, ...]]:
    """Return the sets of functions that are named as components of one vector: f1, f2, f3 or f_x, f_y."""
    found: dict[str, list[str]] = {}
    for name in names:
        stem = name.rstrip("0123456789")
        found.setdefault(stem if stem != name else name.rpartition("_")[0], []).append(name)
    return [tuple(own) for stem, own in found.items() if stem and 1 < len(own) <= LARGEST_SET]


def _lost(
    proof: Proof, seen: Sequence[str], some: tuple[str, ...], kind: Kind, known: Sequence[Need]
) -> Iterator[Need]:
    """Yield what is not observable where the functions are zero or constant, and no smaller set tells."""
    gone = dict.fromkeys(some, ZERO)
    values, rules = (gone, {}) if kind == "zero" else ({}, gone)
    try:
        result = rerun(proof, values, rules)
    except (UndecidedError, UndefinedError):
        return
    if result is None:
        return
    special = analyze(Specialisation(proof.exact.system, values, rules).system(), LIGHT)
    if not isinstance(special, Analysis):
        return
    left = set(_observable(special))
    for target in seen:
        if target not in left and not any(_covers(one, target, some, kind) for one in known):
            yield Need(target, some, kind, special.rank)


def _covers(known: Need, target: str, some: tuple[str, ...], kind: Kind) -> bool:
    """Whether a smaller set costs the same: constant functions cost less than none."""
    weaker = known.kind in (kind, "constant")
    return known.target == target and weaker and set(known.functions) <= set(some)


def _smallest(found: Sequence[Need]) -> tuple[Need, ...]:
    """Return the needs that no smaller set makes superfluous, small sets first: vectors are tried before."""
    return tuple(
        one
        for one in sorted(found, key=lambda one: (len(one.functions), one.kind == "constant"))
        if not any(
            other is not one
            and set(other.functions) < set(one.functions)
            and _covers(other, one.target, one.functions, one.kind)
            for other in found
        )
    )


def _observable(analysis: Analysis) -> tuple[str, ...]:
    states = [name for name, verdict in analysis.states.items() if verdict == "observable"]
    return (*states, *(one.name for one in analysis.quantities if one.verdict == "observable"))
