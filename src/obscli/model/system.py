"""What a model file means: frozen, typed, names resolved, every value remembering its place.

Notation: x (n,) states, y (m,) outputs, A (n, n), H (m, n), B (n, p), G (n, q); x' = A x + B u + G w,
y = H x + v; of a discrete-time system x(k+1) = A x(k) + B u(k) + G w(k), and A is called F there. One
``System`` is one stage of a ``Model`` with all its replacements made.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypeAlias

from obscli.core.place import Place
from obscli.model.expression import Expression
from obscli.model.signal_file import SignalFile


if TYPE_CHECKING:
    from obscli.model.scope import Scope


Assumption: TypeAlias = Literal["real", "positive", "nonzero"]


@dataclass(frozen=True, slots=True, eq=False)
class Parameter:
    """A free constant; ``nominal`` is its value in the file (a constant expression) or None."""

    name: str
    place: Place
    nominal: Expression | None = None
    assume: Assumption = "real"
    unit: str = ""
    description: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Function:
    """A smooth function of time, scalar; ``derivative`` is its rule, None where it is arbitrary."""

    name: str
    place: Place
    derivative: Expression | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Invariant:
    """A relation ``expression = 0`` that the functions satisfy at all times."""

    expression: Expression
    place: Place


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """One scalar state; ``vector`` is the name it was declared under (``psi`` for ``psi1``)."""

    name: str
    place: Place
    vector: str = ""
    unit: str = ""
    description: str = ""
    latex: str = ""
    scale: Expression | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Output:
    """One scalar output; ``vector`` is the name it was declared under (``y`` for ``y1``).

    ``every``: the time between samples, None where the file does not say; ``during``: the intervals in which
    there are samples, None: always.
    """

    name: str
    place: Place
    vector: str = ""
    unit: str = ""
    every: Expression | None = None
    during: tuple[tuple[Expression, Expression], ...] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Matrix:
    """A sparse matrix of expressions: absent entries are zero; places where the file gives them."""

    rows: int
    columns: int
    entries: Mapping[tuple[int, int], Expression]
    places: Mapping[tuple[int, int], Place] = field(default_factory=dict)


#: A linear form in the states: state name → coefficient (absent: zero).
Covector: TypeAlias = Mapping[str, Expression]


@dataclass(frozen=True, slots=True, eq=False)
class Quantity:
    """A named linear combination of interest, or a combination someone asserts something about."""

    name: str
    coefficients: Covector
    place: Place
    text: str = ""


#: Whether an accuracy asked for is reached.
Met: TypeAlias = Literal["met", "missed"]


@dataclass(frozen=True, slots=True, eq=False)
class ExpectedMeasure:
    """What a measure of observability is expected to find.

    Parameters
    ----------
    key : of the measure, as the file has it: whether there is one is for those to say who know them
    target : the state or quantity, or the combination (or mode) as text; None: the system as a whole
    value : a constant; None: infinite
    tolerance : how far off it may be, relative to the value; None: 1e-6
    place : where the value stands
    key_place : where the measure is named
    """

    key: str
    target: str | None
    value: Expression | None
    tolerance: Expression | None
    place: Place
    key_place: Place


#: The stationary systems whose sizes may be expected.
Lifted: TypeAlias = Literal["full", "smallest", "outputs", "same_order"]


@dataclass(frozen=True, slots=True, eq=False)
class ExpectedStationary:
    """How many states the stationary systems have; ``reducible``: whether there are any."""

    place: Place
    reducible: bool
    sizes: Mapping[Lifted, tuple[int, Place]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class Claim:
    """One entry of ``claims`` or ``expect``: what is asserted of a stage, at generic values or ``at`` some.

    ``at`` is None for generic values, "nominal" for the file's, else parameter name → exact value.
    A claim about an experiment may be about some ``runs`` only (empty: all); ``everything`` is where it says
    that all shared states are determined; ``detectable``: whether what is unobservable is said to die out.
    ``requirements``: whether accuracy asked for is met, by state or quantity; "" for all that is asked for;
    ``stationary``: the sizes of time-invariant systems with the same outputs; ``segments``: whether it is
    about the segments together.
    """

    origin: Literal["claims", "expect"]
    place: Place
    stage: str | None = None
    experiment: str | None = None
    runs: tuple[tuple[str, Place], ...] = ()
    at: Mapping[str, Expression] | Literal["nominal"] | None = None
    rank: int | None = None
    rank_place: Place | None = None
    basis: tuple[Quantity, ...] | None = None
    observable: tuple[Quantity, ...] = ()
    unobservable: tuple[Quantity, ...] = ()
    directions: tuple[Quantity, ...] = ()
    states: Mapping[str, tuple[str, Place]] = field(default_factory=dict)
    everything: Place | None = None
    detectable: tuple[bool, Place] | None = None
    measures: tuple[ExpectedMeasure, ...] = ()
    requirements: Mapping[str, tuple[Met, Place]] = field(default_factory=dict)
    stationary: ExpectedStationary | None = None
    segments: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Noise:
    """``noise``: sparse matrices over disturbances (or states, ``driven``), outputs and states.

    Parameters
    ----------
    Q : spectral density of w, None where there is none
    driven : the names Q is over: the states themselves, or the disturbances
    R : spectral density of v, or covariance per sample where there is ``step`` or ``every``; None: not given
    P0 : initial covariance of the states it is given for; a state without an entry has no prior
    step : time between samples
    signals : standard deviation of a sample of a signal, by the scalar function; absent: taken as exact
    place : where the file gives it
    """

    place: Place
    Q: Matrix | None = None
    driven: Literal["states", "disturbances"] = "states"
    R: Matrix | None = None
    P0: Matrix | None = None
    step: Expression | None = None
    signals: Mapping[str, Expression] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class Interval:
    """``interval``: from start to stop, and how many instants; None where the file does not say."""

    place: Place
    start: Expression | None = None
    stop: Expression | None = None
    samples: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class System:
    """One stage: x' = A x, y = H x with everything replaced, ready for an interpreter.

    ``prior`` is the initial standard deviation by state, where ``noise`` gives ``P0`` or ``P0_std``.
    ``scope`` holds what the names of the file stand for in this stage, for expressions given later
    (claims, the command line); None for a system not made from a file. ``fixed``: the names
    that its stage fixes. ``dual``: the matrix of the system of which this one is the dual. ``signals``: files
    with the values of functions; columns of what is no function (any more) mean nothing.
    ``discrete``: x(k+1) = A x(k) with ``time`` the whole number k; ``step``: the seconds from k to k + 1,
    None where the file does not say. Whoever reads A asks which it is, or ``require_continuous`` does.
    """

    stage: str | None
    time: str
    parameters: tuple[Parameter, ...]
    functions: tuple[Function, ...]
    invariants: tuple[Invariant, ...]
    states: tuple[State, ...]
    outputs: tuple[Output, ...]
    A: Matrix
    H: Matrix
    B: Matrix | None = None
    G: Matrix | None = None
    inputs: tuple[str, ...] = ()
    disturbances: tuple[str, ...] = ()
    quantities: tuple[Quantity, ...] = ()
    claims: tuple[Claim, ...] = ()
    noise: Noise | None = None
    prior: Mapping[str, Expression] = field(default_factory=dict)
    interval: Interval | None = None
    scope: Scope | None = None
    fixed: tuple[str, ...] = ()
    dual: Literal["B", "G"] | None = None
    signals: tuple[SignalFile, ...] = ()
    discrete: bool = False
    step: Expression | None = None

    @property
    def dynamics_name(self) -> Literal["A", "F"]:
        """The name of the matrix of the dynamics in the file."""
        return "F" if self.discrete else "A"

    @property
    def n(self) -> int:
        """The number of states."""
        return len(self.states)

    @property
    def m(self) -> int:
        """The number of outputs."""
        return len(self.outputs)

    @property
    def state_names(self) -> tuple[str, ...]:
        """The names of the states, in order."""
        return tuple(state.name for state in self.states)

    @property
    def sampled(self) -> tuple[str, ...]:
        """The names of the functions that are signals, in the order of the functions."""
        columns = {column.name for file in self.signals for column in file.columns}
        return tuple(one.name for one in self.functions if one.name in columns)

    @property
    def interrupted(self) -> tuple[str, ...]:
        """The names of the outputs with outages; a vector's own where all of it has them."""
        whole = {one.vector for one in self.outputs} - {one.vector for one in self.outputs if not one.during}
        whole.discard("")
        names = (one.vector if one.vector in whole else one.name for one in self.outputs if one.during)
        return tuple(dict.fromkeys(names))


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """One run of an experiment: a stage with its replacements made (``system.stage`` is the run's name).

    ``turned``: makes the system with the matrix of a `let` entry multiplied from the right by another, as
    text; None where the system is wrong then. ``fixed``: the names that the run fixes; ``freed`` makes the
    system without fixing one of them.
    """

    name: str
    system: System
    stage: str | None
    place: Place
    turned: Callable[[str, str], System | None] | None = None
    fixed: tuple[str, ...] = ()
    freed: Callable[[str], System | None] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Planning:
    """``plan``: what to choose from (None: the runs of the experiment), what not, time to set up a run.

    ``forbidden``: each a set of candidates of which not all may be chosen; one alone is never chosen.
    """

    candidates: tuple[Run, ...] | None
    forbidden: tuple[tuple[str, ...], ...]
    setup_time: Expression | None


@dataclass(frozen=True, slots=True, eq=False)
class Experiment:
    """Runs in order, and the states they share, in the order of the states; the others start anew."""

    name: str
    description: str
    runs: tuple[Run, ...]
    shared: tuple[str, ...]
    plan: Planning | None = None

    @property
    def everything(self) -> tuple[Run, ...]:
        """All runs, and all candidates of the plan."""
        return (*self.runs, *((self.plan and self.plan.candidates) or ()))


@dataclass(frozen=True, slots=True, eq=False)
class Segment:
    """One segment: a stage with its replacements made, for a while (``system.stage`` is the segment's name).

    ``stop``: where it ends on the axis of time that all segments share; ``jump``: J with x⁺ = J x there, on
    the way to the next one, None: the state goes through as it is; ``run``: the segment as a run.
    """

    run: Run
    duration: Expression
    stop: Expression
    jump: Matrix | None = None

    @property
    def name(self) -> str:
        """The name of the segment."""
        return self.run.name

    @property
    def system(self) -> System:
        """The system in force."""
        return self.run.system


@dataclass(frozen=True, slots=True, eq=False)
class Segments:
    """Segments in order, one after the other from ``start`` on, the whole state carried through.

    ``claims``: those about all of them together.
    """

    start: Expression
    parts: tuple[Segment, ...]
    place: Place
    claims: tuple[Claim, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Requirement:
    """Accuracy asked for: one standard deviation of a state or quantity."""

    name: str
    coefficients: Covector
    value: Expression
    place: Place


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """One file: identification and its systems (stages; the base system first where complete alone).

    ``claims`` are those about an ``experiment``; those about a stage stand with its system.
    """

    name: str
    file: Path
    systems: tuple[System, ...]
    title: str = ""
    description: str = ""
    source: str = ""
    experiment: Experiment | None = None
    require: tuple[Requirement, ...] = ()
    claims: tuple[Claim, ...] = ()
    segments: Segments | None = None
