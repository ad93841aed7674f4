"""``experiment`` and ``plan``: runs read into drafts, lists of stages, grids and repetitions written out."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import Final

from obscli.model.draft import Draft, Entries, Entry
from obscli.model.formula import Formula, formula
from obscli.model.keys import Fields, fields, items_of, text_of, whole_of
from obscli.model.plain import flow_text
from obscli.model.sections import read_draft
from obscli.model.tree import Broken, Mapping, Node, Scalar, Sequence, kind
from obscli.model.trouble import Problems, nearest, shown


EXPERIMENT_KEYS: Final = ("runs", "constant", "fresh", "name", "description")
PLAN_KEYS: Final = ("candidates", "forbidden", "setup_time")
RUN_KEYS: Final = (
    "stage", "name", "description", "let", "parameters", "fix", "interval", "noise", "repeat", "grid",
)  # fmt: skip
MOST_RUNS: Final = 500


@dataclass(frozen=True, slots=True, eq=False)
class RunDraft:
    """One run: a stage (None: the base) with replacements, and exact substitutions made after all others.

    ``turn``: a name under ``let`` and a matrix to multiply its value with from the right.
    """

    name: str
    stage: str | None
    change: Draft
    fix: Entries
    node: Node
    path: str
    turn: tuple[str, Formula] | None = None

    @property
    def changes_nothing(self) -> bool:
        """Whether the run is its stage as it stands."""
        return self.change.is_empty and not self.fix and self.turn is None


@dataclass(frozen=True, slots=True, eq=False)
class ExperimentDraft:
    """Runs in order; names of states or vectors that are shared (None: by default) and that are not."""

    node: Node
    name: str
    description: str
    runs: tuple[RunDraft, ...]
    constant: tuple[Scalar, ...] | None = None
    fresh: tuple[Scalar, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class PlanDraft:
    """Candidate runs (None: those of the experiment), what may not be chosen, time to set up a run."""

    node: Node
    candidates: tuple[RunDraft, ...] | None
    forbidden: tuple[Node, ...] = ()
    setup_time: Formula | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """The names that runs may use."""

    stages: Collection[str]
    states: Collection[str]
    fixable: Collection[str]


def read_experiment(node: Node | None, known: Known, problems: Problems) -> ExperimentDraft | None:
    """Read ``experiment``; None where there is none."""
    if node is None or isinstance(node, Broken):
        return None
    given = fields(node, "experiment", EXPERIMENT_KEYS, problems)
    if "runs" not in given and (isinstance(node, Mapping) or _is_null(node)):
        hint = "name the stages, or give mappings: runs: [stage_1, {stage: stage_1, fix: {omega: -omega}}]"
        problems.add(node.problem("experiment", "`runs` is missing: what is done, in order", hint))
    constant = _states(given, "constant", known, problems) if "constant" in given else None
    fresh = _states(given, "fresh", known, problems)
    for item in fresh:
        if constant is not None and item.text in {one.text for one in constant}:
            message = f"'{shown(item.text)}' stands under `constant` too; one of the two"
            problems.add(item.problem("experiment.fresh", message))
    return ExperimentDraft(
        node,
        text_of(given.get("name"), "experiment.name", problems),
        text_of(given.get("description"), "experiment.description", problems),
        _runs(given, "runs", "experiment", known, problems),
        constant,
        fresh,
    )


def read_plan(node: Node | None, known: Known, problems: Problems) -> PlanDraft | None:
    """Read ``plan``; None where there is none."""
    if node is None or isinstance(node, Broken):
        return None
    given = fields(node, "plan", PLAN_KEYS, problems)
    if not (isinstance(node, Mapping) or _is_null(node)):
        return None
    candidates = _runs(given, "candidates", "plan", known, problems) if "candidates" in given else None
    forbidden = items_of(given["forbidden"][1], "plan.forbidden", problems) if "forbidden" in given else ()
    setup = formula(given["setup_time"][1], "plan.setup_time", problems) if "setup_time" in given else None
    return PlanDraft(node, candidates, forbidden, setup)


def _states(given: Fields, key: str, known: Known, problems: Problems) -> tuple[Scalar, ...]:
    path = f"experiment.{key}"
    items = items_of(given[key][1], path, problems) if key in given else ()
    found = [item for item in items if is_known(item, path, known.states, "state", problems)]
    return tuple(item for item in found if isinstance(item, Scalar))


def is_known(node: Node, path: str, known: Collection[str], what: str, problems: Problems) -> bool:
    """Whether a node is a name that is known; what it is else is reported."""
    name = node.text if isinstance(node, Scalar) else ""
    if not isinstance(node, Scalar | Broken) or _is_null(node):
        problems.add(node.problem(path, f"the name of a {what} is expected here, not {kind(node)}"))
        return False
    if name not in known and not isinstance(node, Broken):
        problems.add(node.problem(path, f"there is no {what} '{shown(name)}'{nearest(name, known)}"))
    return name in known


def _runs(given: Fields, key: str, above: str, known: Known, problems: Problems) -> tuple[RunDraft, ...]:
    """Read a list of runs; every run gets a name of its own."""
    if key not in given:
        return ()
    path = f"{above}.{key}"
    found: list[RunDraft] = []
    for k, item in enumerate(filled(given[key][1], path, problems), start=1):
        for run in _written_out(item, f"{path}[{k}]", known, problems):
            if len(found) == MOST_RUNS:
                message = f"more than {MOST_RUNS} runs"
                problems.add(item.problem(path, message, "give fewer values in `grid`, or several files"))
                return ()
            found.append(run)
    return named_apart(found, path, problems)


def filled(node: Node, path: str, problems: Problems) -> tuple[Node, ...]:
    """Return the items of a list, which must have some."""
    items = items_of(node, path, problems)
    if isinstance(node, Sequence) and not items:
        problems.add(node.problem(path, "the list is empty"))
    return items


def _written_out(node: Node, path: str, known: Known, problems: Problems) -> Iterator[RunDraft]:
    """Yield the runs of one entry: every stage of its list, every combination of its grid, repeated."""
    if not isinstance(node, Mapping):
        if is_known(node, path, known.stages, "stage", problems) and isinstance(node, Scalar):
            yield RunDraft(node.text, node.text, Draft(node), {}, node, path)
        return
    given = fields(node, path, RUN_KEYS, problems)
    change = read_draft(node, path, RUN_KEYS, problems)
    name = text_of(given.get("name"), f"{path}.name", problems)
    text_of(given.get("description"), f"{path}.description", problems)
    repeat = 1
    if "repeat" in given:
        repeat = whole_of(given["repeat"][1], f"{path}.repeat", problems, most=MOST_RUNS) or 1
    check_fixable(given, path, known, problems)
    fix = {one: entry for one, entry in change.fix.items() if one in known.fixable and entry.formula}
    axes = {one: values for one, values in _axes(given, path, problems).items() if one in known.fixable}
    stages = _stages(given, path, known, problems)
    for stage in stages:
        base = f"{name} {stage}" if name and len(stages) > 1 else name
        for values in product(*axes.values()):
            chosen = dict(zip(axes, values, strict=True))
            title = label(base, stage, {**({} if name else fix), **chosen})
            yield from (RunDraft(title, stage, change, {**fix, **chosen}, node, path),) * repeat


def _stages(given: Fields, path: str, known: Known, problems: Problems) -> list[str | None]:
    """Return the stages of an entry: one, each of a list, or the base."""
    if "stage" not in given:
        return [None]
    value = given["stage"][1]
    nodes = filled(value, f"{path}.stage", problems) if isinstance(value, Sequence) else (value,)
    return [
        one.text
        for one in nodes
        if is_known(one, f"{path}.stage", known.stages, "stage", problems) and isinstance(one, Scalar)
    ]


def check_fixable(given: Fields, path: str, known: Known, problems: Problems) -> None:
    """Report what is fixed, or runs over a grid, without being a parameter or function."""
    for key in ("fix", "grid"):
        entries = fields(given[key][1], f"{path}.{key}", None, problems) if key in given else {}
        for name, (word, value) in entries.items():
            is_known(word, f"{path}.{key}", known.fixable, "parameter or function", problems)
            if key == "fix" and _is_null(value):
                problems.add(value.problem(f"{path}.fix.{name}", "an expression is missing here"))


def _axes(given: Fields, path: str, problems: Problems) -> dict[str, tuple[Entry, ...]]:
    """Return the values of every name in ``grid``."""
    if "grid" not in given:
        return {}
    axes = {}
    for name, (key, value) in fields(given["grid"][1], f"{path}.grid", None, problems).items():
        below = f"{path}.grid.{name}"
        items = filled(value, below, problems)[: MOST_RUNS + 1]
        for item in filter(_is_null, items):
            problems.add(item.problem(below, "an expression is missing here"))
        values = (item for item in items if not _is_null(item))
        axes[name] = tuple(Entry(key, formula(item, below, problems)) for item in values)
    return axes


def _is_null(node: Node) -> bool:
    return isinstance(node, Scalar) and node.is_null


def label(name: str, stage: str | None, fix: Entries) -> str:
    """Return the name of a run: as given, else its stage, with the values it is told apart by."""
    texts = {one: _text(entry) for one, entry in fix.items()}
    values = ", ".join(f"{one} = {text}" for one, text in texts.items() if text != one)
    base = name or stage or ""
    return f"{base} ({values})" if base and values else base or values or "run"


def _text(entry: Entry) -> str:
    return "" if entry.formula is None else entry.formula.text or flow_text(entry.formula.node)


def named_apart(runs: list[RunDraft], path: str, problems: Problems) -> tuple[RunDraft, ...]:
    """Number runs of the same name: ``x``, ``x #2``; different runs given the same name are reported."""
    taken: dict[str, RunDraft] = {}
    for run in runs:
        first = taken.get(run.name)
        if first is not None and first.node is not run.node and (_given(first) or _given(run)):
            message = f"there is a run '{shown(run.name)}' already, in line {first.node.place.line}"
            problems.add((_given(run) or run.node).problem(path, message, "give every run a name of its own"))
        k, name = 1, run.name
        while name in taken:
            k, name = k + 1, f"{run.name} #{k + 1}"
        taken[name] = replace(run, name=name)
    return tuple(taken.values())


def _given(run: RunDraft) -> Scalar | None:
    """Return the name the file gives the run."""
    name = run.node.get("name") if isinstance(run.node, Mapping) else None
    return name if isinstance(name, Scalar) and not name.is_null else None
