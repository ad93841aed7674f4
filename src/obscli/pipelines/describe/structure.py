"""The structure: how the unobservable subspace moves by itself, and whether what is hidden dies out."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from obscli.checks.detectability import ALL_TIMES, Detectability, time_constant
from obscli.core.document import (
    Block,
    Cell,
    Column,
    Heading,
    Kind,
    Listing,
    Paragraph,
    Role,
    Table,
    Text,
    VerdictLine,
    line,
    plain,
)
from obscli.core.number import counted, short
from obscli.exact.finding import Analysis
from obscli.exact.structure_finding import Mode, ModeKind, OnCondition, Structure
from obscli.model.system import System
from obscli.pipelines.describe.formulas import direction
from obscli.pipelines.describe.hidden_motion import cross_check_blocks, motion_blocks
from obscli.pipelines.describe.relations import relation_blocks
from obscli.pipelines.stage_result import StageResult


MODE_COLUMNS: Final = (
    Column("eigenvalue"),
    Column("kind"),
    Column("time", "right"),
    Column("direction", breaks=True),
)
LEGEND: Final = (
    "What no output shows moves by itself as exp(s t), s the eigenvalue. Time: in which it falls to 1/e, or "
    "grows e-fold."
)
LEGEND_OF_STEPS: Final = (
    "What no output shows moves by itself as s^k, s the eigenvalue, k the step. Time: the steps in which it "
    "falls to 1/e, or grows e-fold; 0: it is gone after at most as many steps as it has directions."
)
ROLES: Final[dict[ModeKind, Role]] = {
    "decaying": "good",
    "neutral": "bad",
    "growing": "bad",
    "depends": "open",
    "undecided": "open",
}
PARTS: Final = (
    "reachable and unobservable",
    "reachable and observable",
    "unobservable only",
    "observable only",
)
KINDS: Final[dict[str, Kind]] = {"observable": "good", "detectable": "good", "not detectable": "bad"}


def structure_blocks(result: StageResult) -> Iterator[Block]:
    """Yield the modes and the verdict, generic and at the file's values, and where the verdict changes."""
    finding, found = result.finding, result.detectability
    if not isinstance(finding, Analysis) or finding.structure is None or found is None:
        return
    structure, there = finding.structure, result.detectability_there
    yield Heading(2, plain("Structure"))
    yield from mode_blocks(structure, result.system)
    yield from motion_blocks(found, result.system)
    if structure.verdict == "depends":
        yield VerdictLine("info", plain(f"detectable iff {structure.condition}"))
    yield _verdict_line(found, "" if there is None else "at generic values, ")
    yield from _kalman(structure)
    yield from on_condition_blocks(structure)
    if there is not None:
        yield Paragraph(
            plain(f"At the file's values, {counted(there.of.dimension, 'direction')} unobservable:")
        )
        yield from mode_blocks(there.of, result.system)
        yield from motion_blocks(there, result.system)
        yield _verdict_line(there, "at the file's values, ")
        yield from _kalman(there.of)
    yield from cross_check_blocks(result)
    if finding.relations is not None:
        yield from relation_blocks(finding.relations, result.system)


def _kalman(structure: Structure) -> Iterator[Block]:
    """Yield the dimensions of the four parts of the Kalman decomposition, where there are inputs."""
    if structure.kalman is not None:
        inputs = "inputs (B)" if structure.inputs == "B" else "disturbances (G)"
        sizes = zip(structure.kalman, PARTS, strict=True)
        parts = ", ".join(f"{size} {part}" for size, part in sizes if size)
        yield Paragraph(plain(f"Kalman decomposition by {inputs}: {parts}."))


def _verdict_line(found: Detectability, where: str) -> VerdictLine:
    scope = "" if found.scope == ALL_TIMES else f" {found.where}"
    return VerdictLine(
        KINDS.get(found.verdict, "open"), plain(f"{where}{found.verdict}{scope}: {found.words}")
    )


def mode_blocks(structure: Structure, system: System) -> Iterator[Block]:
    """Yield the modes of the unobservable subspace, those of one eigenvalue together."""
    if not structure.modes:
        return
    groups: dict[tuple[str, ModeKind, bool], list[Mode]] = {}
    for mode in structure.modes:
        groups.setdefault((mode.eigenvalue, mode.kind, mode.chained), []).append(mode)
    rows = tuple(_mode_row(modes, structure, system) for modes in groups.values())
    yield Table(MODE_COLUMNS, rows, (Text(LEGEND_OF_STEPS if system.discrete else LEGEND, "faint"),))


def _mode_row(modes: list[Mode], structure: Structure, system: System) -> tuple[Cell, ...]:
    first = modes[0]
    everything = len(modes) == structure.dimension > 1
    directions: Cell = (
        line(Text(f"every unobservable direction ({len(modes)})"))
        if everything
        else tuple((direction(mode.direction, system),) for mode in modes)
    )
    moves = f"{first.eigenvalue}, driven by the others" if first.chained else first.eigenvalue
    return line(Text(moves)), _kind(first), line(Text(_time(first))), directions


def _kind(mode: Mode) -> Cell:
    if mode.kind != "depends":
        return _word(mode.kind)
    condition = f"decays iff {mode.condition}" if mode.condition else "never decays"
    if mode.kind_there == "undecided":
        return line(Text(condition, "open"))
    return (
        (Text(condition, "open"),),
        (Text("here: ", "faint"), Text(mode.kind_there, ROLES[mode.kind_there])),
    )


def _word(kind: ModeKind) -> Cell:
    return line(Text(kind, ROLES[kind]))


def _time(mode: Mode) -> str:
    time = time_constant(mode)
    return "–" if time is None else short(time, 3)


def on_condition_blocks(structure: Structure) -> Iterator[Block]:
    """Yield what becomes of the verdict where the rank drops, as far as it changes."""
    changed = [one for one in structure.critical if one.structure.verdict != structure.verdict]
    if changed:
        yield Listing(tuple(plain(_on_condition(one)) for one in changed))


def _on_condition(one: OnCondition) -> str:
    there = one.structure
    verdict = f"detectable iff {there.condition}" if there.verdict == "depends" else there.verdict
    moves = ", ".join(dict.fromkeys(mode.eigenvalue for mode in there.modes))
    grounds = f" (eigenvalue {moves})" if moves else ""
    return f"where {one.condition}, {counted(there.dimension, 'direction')} unobservable: {verdict}{grounds}"
