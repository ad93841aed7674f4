"""A measure of observability: what it is called, how it is read, and the function that finds it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, TypeAlias

from obscli.model.expression import Expression


if TYPE_CHECKING:
    from obscli.measures.subject import Subject

#: Which values mean better observable.
Better: TypeAlias = Literal["larger", "smaller"]

#: What a measure is found from: the matrix M at an instant, samples without noise, the model of the noise.
Basis: TypeAlias = Literal["matrix", "samples", "noise"]


class NotMeasuredError(ValueError):
    """A measure does not exist for this system as it stands; the text says why, and what to do."""


@dataclass(frozen=True, slots=True, eq=False)
class Direction:
    """One singular value, eigenvalue or mode with what belongs to it.

    ``components``: the direction by state, the largest component 1; ``eigenvalue``: of A, where it is a mode.
    """

    value: float
    components: Mapping[str, float]
    eigenvalue: complex | None = None


#: What is said of the system as a whole.
SystemValue: TypeAlias = float | tuple[Direction, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """What one measure finds.

    Parameters
    ----------
    targets : its value for every target of the subject in order, None where it is not defined; empty where
        the measure is of the system alone
    system : by key, what it says of the system
    forms : closed forms by name of the target, or by key of the system
    remarks : what the reader has to know
    """

    targets: tuple[float | None, ...] = ()
    system: Mapping[str, SystemValue] = field(default_factory=dict)
    forms: Mapping[str, Expression] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Option:
    """An option of a measure, ``--option least-squares.dt=1``: a number, or one of some words."""

    name: str
    default: float | str
    meaning: str
    choices: tuple[str, ...] = ()
    whole: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Measure:
    """One measure of observability.

    Parameters
    ----------
    key : its name in options and JSON
    symbol : its heading in a table
    title : its name in words
    reference : where it comes from
    reading : how it is read: what the value means, and on what it depends
    compute : finds it; raises ``NotMeasuredError`` or ``NotComputableError``
    basis : what it is found from
    better : which values mean better observable; None: it is of the system alone
    scaled : whether it changes with the units of the states
    options : with their defaults
    always : whether it is found unasked
    """

    key: str
    symbol: str
    title: str
    reference: str
    reading: str
    compute: Callable[[Subject], Found]
    basis: Basis
    better: Better | None = None
    scaled: bool = True
    options: tuple[Option, ...] = ()
    always: bool = True
