"""What the file says, section by section, parsed but not yet evaluated; a stage is a draft of its own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TypeAlias

from obscli.model.declaration import Declared
from obscli.model.formula import Formula
from obscli.model.signal_draft import SignalFileDraft
from obscli.model.tree import Mapping as MappingNode
from obscli.model.tree import Node, Scalar


@dataclass(frozen=True, slots=True, eq=False)
class Entry:
    """A key with its expression, None where nothing is written (or it is already reported)."""

    key: Scalar
    formula: Formula | None


Entries: TypeAlias = Mapping[str, Entry]


@dataclass(frozen=True, slots=True, eq=False)
class ParameterDraft:
    """One entry of ``parameters``; empty texts where the file says nothing."""

    key: Scalar
    value: Formula | None
    assume: str = ""
    unit: str = ""
    description: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class FunctionDraft:
    """One entry of ``functions``, or one that ``signals`` implies."""

    declared: Declared
    derivative: Formula | None = None
    invariants: tuple[Formula, ...] = ()
    implied: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Sparse:
    """A matrix by rows and columns: row name → column name → expression, or a whole row."""

    node: Node
    path: str
    rows: Mapping[str, tuple[Scalar, Entries | Formula]]


@dataclass(frozen=True, slots=True, eq=False)
class SpanDraft:
    """An interval ``[start, stop]``."""

    node: Node
    path: str
    start: Formula
    stop: Formula


@dataclass(frozen=True, slots=True, eq=False)
class OutputDraft:
    """One entry of ``outputs``; empty and None where the file says nothing."""

    key: Scalar
    unit: str = ""
    every: Formula | None = None
    during: tuple[SpanDraft, ...] | None = None


MatrixDraft: TypeAlias = Formula | Sparse


@dataclass(frozen=True, slots=True, eq=False)
class Draft:
    """The sections of a file or of a stage; None and empty where absent.

    ``signals`` as written, ``sampled`` as read; the functions that they imply are among ``functions``.
    """

    node: Node
    time: str = ""
    time_key: Scalar | None = None
    parameters: Mapping[str, ParameterDraft] = field(default_factory=dict)
    functions: tuple[FunctionDraft, ...] = ()
    states: tuple[Declared, ...] = ()
    states_sound: bool = True
    inputs: tuple[Declared, ...] = ()
    disturbances: tuple[Declared, ...] = ()
    let: Entries = field(default_factory=dict)
    fix: Entries = field(default_factory=dict)
    quantities: Entries = field(default_factory=dict)
    dynamics: Entries | None = None
    measurements: Entries | None = None
    matrices: Mapping[str, MatrixDraft] = field(default_factory=dict)
    outputs: Mapping[str, OutputDraft] = field(default_factory=dict)
    noise: Node | None = None
    interval: Node | None = None
    signals: Node | None = None
    sampled: tuple[SignalFileDraft, ...] | None = None
    linearize: Entries | None = None
    step: Node | None = None

    @property
    def is_discrete(self) -> bool:
        """Whether the dynamics are those of a discrete-time system."""
        return "F" in self.matrices

    def indexed(self, name: str) -> Draft:
        """Return the draft with a time symbol where it gives none."""
        return self if self.time else replace(self, time=name)

    @property
    def is_empty(self) -> bool:
        """Whether a stage changes nothing."""
        return not (
            self.parameters
            or self.let
            or self.fix
            or self.matrices
            or self.outputs
            or any(part is not None for part in (self.dynamics, self.measurements, self.noise))
            or any(part is not None for part in (self.interval, self.signals))
        )


def merged(base: Draft, stage: Draft) -> Draft:
    """Return the base with the replacements of a stage; a replaced entry keeps its place."""
    matrices = {**base.matrices, **_merged_matrices(base, stage)}
    if stage.dynamics is not None:
        matrices.pop("A", None)
    if stage.measurements is not None:
        matrices.pop("H", None)
    return replace(
        base,
        parameters={**base.parameters, **_merged_parameters(base, stage)},
        let=_merged_let(base.let, stage.let),
        fix={**base.fix, **stage.fix},
        dynamics=None if "A" in stage.matrices else _joined(base.dynamics, stage.dynamics),
        measurements=None if "H" in stage.matrices else _joined(base.measurements, stage.measurements),
        matrices=matrices,
        outputs={**base.outputs, **_merged_outputs(base, stage)},
        noise=merged_nodes(base.noise, stage.noise),
        interval=merged_nodes(base.interval, stage.interval),
        functions=_merged_functions(base, stage),
        signals=merged_nodes(base.signals, stage.signals),
        sampled=base.sampled if stage.sampled is None else stage.sampled,
    )


def _merged_functions(base: Draft, stage: Draft) -> tuple[FunctionDraft, ...]:
    """Replace the functions that signals imply, where the stage has signals of its own."""
    if stage.sampled is None:
        return base.functions
    listed = tuple(one for one in base.functions if not one.implied)
    return (*listed, *(one for one in stage.functions if one.implied))


def _joined(base: Entries | None, stage: Entries | None) -> Entries | None:
    if base is None or stage is None:
        return base if stage is None else stage
    return {**base, **stage}


def merged_nodes(base: Node | None, stage: Node | None) -> Node | None:
    """Replace the keys given where both are mappings, else the whole."""
    if isinstance(base, MappingNode) and isinstance(stage, MappingNode):
        given = {key.text for key, _ in stage.entries}
        kept = tuple(entry for entry in base.entries if entry[0].text not in given)
        return MappingNode(stage.source, stage.line, stage.column, kept + stage.entries)
    return base if stage is None else stage


def _merged_parameters(base: Draft, stage: Draft) -> dict[str, ParameterDraft]:
    """Replace what the stage states of a parameter; the rest stays."""
    result = {}
    for name, new in stage.parameters.items():
        old = base.parameters.get(name)
        if old is not None:
            result[name] = ParameterDraft(
                old.key,
                new.value or old.value,
                new.assume or old.assume,
                new.unit or old.unit,
                new.description or old.description,
            )
    return result


def _merged_outputs(base: Draft, stage: Draft) -> dict[str, OutputDraft]:
    """Replace what the stage states of an output; the rest stays."""
    result = dict(stage.outputs)
    for name, new in stage.outputs.items():
        old = base.outputs.get(name)
        if old is not None:
            during = old.during if new.during is None else new.during
            result[name] = OutputDraft(new.key, new.unit or old.unit, new.every or old.every, during)
    return result


def _merged_matrices(base: Draft, stage: Draft) -> dict[str, MatrixDraft]:
    """Replace rows where both are sparse, else the whole matrix."""
    result: dict[str, MatrixDraft] = {}
    for name, new in stage.matrices.items():
        old = base.matrices.get(name)
        both = isinstance(old, Sparse) and isinstance(new, Sparse)
        result[name] = Sparse(new.node, new.path, {**old.rows, **new.rows}) if both else new  # type: ignore[union-attr]
    return result


def _merged_let(base: Entries, stage: Entries) -> Entries:
    """Replace entries in place; new ones stand as early as the entries they use allow."""
    result = {**base, **stage}
    rank = {name: (k, 0) for k, name in enumerate(base)}
    for k, (name, entry) in enumerate(stage.items(), start=1):
        used = entry.formula.names if entry.formula else frozenset()
        if name not in base:
            rank[name] = (max((rank[known][0] for known in used if known in rank), default=-1), k)
    return {name: result[name] for name in sorted(result, key=rank.__getitem__)}
