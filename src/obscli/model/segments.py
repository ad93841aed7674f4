"""``segments`` read into drafts: what is in force, for how long, and how the state jumps at the end."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

from obscli.model.draft import Entries
from obscli.model.experiment import Known, RunDraft, check_fixable, filled, is_known, label, named_apart
from obscli.model.formula import Formula, formula
from obscli.model.keys import Fields, fields, text_of
from obscli.model.sections import entries, read_draft
from obscli.model.tree import Broken, Mapping, Node, Scalar, Sequence, kind
from obscli.model.trouble import Problems


SEGMENT_KEYS: Final = (
    "stage", "name", "description", "duration", "jump", "fix", "let", "parameters", "noise",
)  # fmt: skip
MOST_SEGMENTS: Final = 500
_EXAMPLE: Final = "segments: [{stage: climb, duration: 30}, {stage: cruise, duration: 600}]"


@dataclass(frozen=True, slots=True, eq=False)
class SegmentDraft:
    """One segment: as a run, how long, and the right-hand sides of the states that jump at its end."""

    run: RunDraft
    duration: Formula
    jump: Entries | None


@dataclass(frozen=True, slots=True, eq=False)
class SegmentsDraft:
    """The segments of a file in order."""

    node: Node
    parts: tuple[SegmentDraft, ...]


def read_segments(node: Node | None, known: Known, problems: Problems) -> SegmentsDraft | None:
    """Read ``segments``; None where there are none."""
    if node is None or isinstance(node, Broken):
        return None
    if not isinstance(node, Sequence):
        what = f"a list of segments is expected here, in order, not {kind(node)}"
        problems.add(node.problem("segments", what, _EXAMPLE))
        return None
    items = filled(node, "segments", problems)
    if len(items) > MOST_SEGMENTS:
        hint = "make a stage that varies with time of those that are alike"
        problems.add(node.problem("segments", f"more than {MOST_SEGMENTS} segments", hint))
        return None
    found = [_segment(item, f"segments[{k}]", known, problems) for k, item in enumerate(items, start=1)]
    parts = [one for one in found if one is not None]
    names = named_apart([one.run for one in parts], "segments", problems)
    return SegmentsDraft(node, tuple(replace(one, run=run) for one, run in zip(parts, names, strict=True)))


def _segment(node: Node, path: str, known: Known, problems: Problems) -> SegmentDraft | None:
    if not isinstance(node, Mapping):
        what = f"a segment is a mapping with its `duration`, not {kind(node)}"
        problems.add(node.problem(path, what, _EXAMPLE))
        return None
    given = fields(node, path, SEGMENT_KEYS, problems)
    change = read_draft(node, path, SEGMENT_KEYS, problems)
    name = text_of(given.get("name"), f"{path}.name", problems)
    text_of(given.get("description"), f"{path}.description", problems)
    stage = _stage(given, path, known, problems)
    check_fixable(given, path, known, problems)
    fix = {one: entry for one, entry in change.fix.items() if one in known.fixable and entry.formula}
    run = RunDraft(name or label("", stage, fix), stage, change, fix, node, path)
    duration = _duration(given, node, path, problems)
    return None if duration is None else SegmentDraft(run, duration, _jump(given, path, problems))


def _stage(given: Fields, path: str, known: Known, problems: Problems) -> str | None:
    if "stage" not in given:
        return None
    node = given["stage"][1]
    found = is_known(node, f"{path}.stage", known.stages, "stage", problems)
    return node.text if found and isinstance(node, Scalar) else None


def _duration(given: Fields, node: Node, path: str, problems: Problems) -> Formula | None:
    value = given["duration"][1] if "duration" in given else None
    if value is None or (isinstance(value, Scalar) and value.is_null):
        hint = "how long it is in force, in units of time: duration: 30"
        problems.add((value or node).problem(path, "`duration` is missing", hint))
        return None
    return formula(value, f"{path}.duration", problems)


def _jump(given: Fields, path: str, problems: Problems) -> Entries | None:
    """Read the right-hand sides of what jumps; the other states go through as they are."""
    if "jump" not in given:
        return None
    found = entries(given["jump"][1], f"{path}.jump", problems)
    for name, entry in found.items():
        if entry.formula is None:
            problems.add(entry.key.problem(f"{path}.jump.{name}", "an expression is missing here"))
    return {name: entry for name, entry in found.items() if entry.formula is not None}
