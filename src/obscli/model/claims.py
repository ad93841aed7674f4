"""``claims`` and ``expect``: what is asserted of a stage, read once, evaluated in each stage's scope."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

from obscli.core.place import Place
from obscli.model.constant import constant
from obscli.model.expected import (
    MeasureDraft,
    RequiredDraft,
    Subjects,
    expected_measures,
    expected_requirements,
    read_measures,
    read_required,
    read_stationary,
)
from obscli.model.expression import Expression, Symbol, is_zero
from obscli.model.formula import Formula, formula
from obscli.model.keys import Fields, choice_of, fields, items_of, text_of, whole_of
from obscli.model.linear import quantity
from obscli.model.plain import flow_text
from obscli.model.scope import Scope
from obscli.model.system import Claim, ExpectedStationary, Experiment, Quantity, State
from obscli.model.tree import Broken, Node, Scalar
from obscli.model.tree import Mapping as MappingNode
from obscli.model.tree import Sequence as SequenceNode
from obscli.model.trouble import Problems, nearest, shown


Origin = Literal["claims", "expect"]
VERDICTS: Final = ("observable", "coupled", "unobservable")
COMBINATIONS: Final = ("basis", "observable", "unobservable")
CLAIM_KEYS: Final = (
    "stage", "experiment", "runs", "segments", "at", "rank", *COMBINATIONS, "directions", "states",
    "determined", "detectable",
)  # fmt: skip
EXPECT_KEYS: Final = (*CLAIM_KEYS, "measures", "require", "stationary")


@dataclass(frozen=True, slots=True, eq=False)
class ClaimDraft:
    """One entry, parsed: its combinations and directions wait for a scope."""

    origin: Origin
    node: Node
    path: str
    given: Fields
    stage: str
    experiment: str
    rank: int | None
    combinations: Mapping[str, tuple[Formula, ...]]
    directions: tuple[tuple[Node, Mapping[str, tuple[Scalar, Formula]]], ...]
    at: Mapping[str, tuple[Scalar, Formula]] | Literal["nominal"] | None
    measures: tuple[MeasureDraft, ...]
    required: tuple[RequiredDraft, ...]
    stationary: ExpectedStationary | None = None
    known: tuple[str, ...] | None = None  # the runs there are, where somebody knows
    segments: bool = False


def read_claims(
    node: Node | None, origin: Origin, stages: Collection[str], problems: Problems
) -> tuple[ClaimDraft, ...]:
    """Read the list of claims; a single one may stand without the list."""
    if node is None or isinstance(node, Broken) or (isinstance(node, Scalar) and node.is_null):
        return ()
    items = (node,) if isinstance(node, MappingNode) else items_of(node, origin, problems)
    return tuple(
        _read(item, origin, f"{origin}[{k}]", stages, problems) for k, item in enumerate(items, start=1)
    )


def _read(node: Node, origin: Origin, path: str, stages: Collection[str], problems: Problems) -> ClaimDraft:
    given = fields(node, path, EXPECT_KEYS if origin == "expect" else CLAIM_KEYS, problems)
    stage = text_of(given.get("stage"), f"{path}.stage", problems)
    if stage and stage not in stages:
        message = f"there is no stage '{shown(stage)}'{nearest(stage, stages)}"
        problems.add(given["stage"][1].problem(f"{path}.stage", message))
    rank = whole_of(given["rank"][1], f"{path}.rank", problems, least=0) if "rank" in given else None
    combinations: dict[str, tuple[Formula, ...]] = {
        key: tuple(
            formula(item, f"{path}.{key}[{k}]", problems)
            for k, item in enumerate(items_of(given[key][1], f"{path}.{key}", problems), start=1)
        )
        for key in COMBINATIONS
        if key in given
    }
    directions = given.get("directions")
    return ClaimDraft(
        origin, node, path, given, stage, text_of(given.get("experiment"), f"{path}.experiment", problems),
        rank, combinations,
        tuple(
            (item, _assignments(item, f"{path}.directions[{k}]", problems))
            for k, item in enumerate(
                items_of(directions[1], f"{path}.directions", problems) if directions else (), start=1
            )
        ),
        _at(given["at"][1], f"{path}.at", problems) if "at" in given else None,
        read_measures(given["measures"][1], f"{path}.measures", problems) if "measures" in given else (),
        read_required(given["require"][1], f"{path}.require", problems) if "require" in given else (),
        _stationary(given, path, problems),
        segments=_segments(given, path, problems),
    )  # fmt: skip


def _stationary(given: Fields, path: str, problems: Problems) -> ExpectedStationary | None:
    node = given["stationary"][1] if "stationary" in given else None
    return read_stationary(node, f"{path}.stationary", problems)


def _segments(given: Fields, path: str, problems: Problems) -> bool:
    """Whether a claim is about the segments together."""
    if "segments" not in given:
        return False
    for other in ("stage", "experiment"):
        if other in given:
            message = f"`segments` and `{other}` are both given; one of the two"
            problems.add(given[other][0].problem(path, message))
    return choice_of(given["segments"], f"{path}.segments", ("true",), problems) == "true"


def _at(
    node: Node, path: str, problems: Problems
) -> Mapping[str, tuple[Scalar, Formula]] | Literal["nominal"] | None:
    if isinstance(node, MappingNode):
        return _assignments(node, path, problems)
    if isinstance(node, Scalar) and node.text == "nominal":
        return "nominal"
    if not isinstance(node, Broken):
        problems.add(node.problem(path, "'nominal' or a mapping of parameters to values is expected here"))
    return None


def _assignments(node: Node, path: str, problems: Problems) -> dict[str, tuple[Scalar, Formula]]:
    return {
        name: (key, formula(value, f"{path}.{name}", problems))
        for name, (key, value) in fields(node, path, None, problems).items()
    }


def claims_of(
    drafts: tuple[ClaimDraft, ...], scope: Scope, subjects: Subjects, problems: Problems
) -> tuple[Claim, ...]:
    """Return the claims in the scope of one stage."""
    return tuple(_claim(draft, scope, subjects, problems) for draft in drafts)


def about(drafts: tuple[ClaimDraft, ...], stage: str | None) -> tuple[ClaimDraft, ...]:
    """Return the claims about a stage: those that name it, and those that name none."""
    return tuple(
        one for one in drafts if not one.experiment and not one.segments and one.stage in {"", stage}
    )


def _claim(draft: ClaimDraft, scope: Scope, subjects: Subjects, problems: Problems) -> Claim:
    states = subjects.states
    found = {
        key: tuple(
            one
            for item in draft.combinations.get(key, ())
            for one in quantity(_label(item), item, scope, problems)
        )
        for key in COMBINATIONS
    }
    return Claim(
        origin=draft.origin,
        place=draft.node.place,
        stage=draft.stage or None,
        experiment=draft.experiment or None,
        runs=_runs(draft, problems),
        at=_values(draft, scope, problems),
        rank=draft.rank,
        rank_place=draft.given["rank"][1].place if "rank" in draft.given else None,
        basis=found["basis"] if "basis" in draft.combinations else None,
        observable=found["observable"],
        unobservable=found["unobservable"],
        directions=tuple(_directions(draft, scope, states, problems)),
        states=_together(draft, states, problems),
        everything=_everything(draft),
        detectable=_detectable(draft, problems),
        measures=expected_measures(draft.measures, f"{draft.path}.measures", subjects, scope, problems),
        requirements=expected_requirements(draft.required, f"{draft.path}.require", subjects, problems),
        stationary=draft.stationary,
        segments=draft.segments,
    )


def _runs(draft: ClaimDraft, problems: Problems) -> tuple[tuple[str, Place], ...]:
    if "runs" not in draft.given:
        return ()
    key, node = draft.given["runs"]
    if not draft.experiment:
        hint = "name the experiment: `experiment: NAME`"
        problems.add(key.problem(draft.path, "`runs` belongs to a claim about an experiment", hint))
    path = f"{draft.path}.runs"
    items = items_of(node, path, problems)
    if isinstance(node, SequenceNode) and not items:
        problems.add(node.problem(path, "the list is empty"))
    if draft.known is not None:
        for item in items:
            name = item.text if isinstance(item, Scalar) else ""
            if name not in draft.known:
                problems.add(
                    item.problem(path, f"there is no run '{shown(name)}'{nearest(name, draft.known)}")
                )
    return tuple((item.text, item.place) for item in items if isinstance(item, Scalar))


def _everything(draft: ClaimDraft) -> Place | None:
    """Return where `determined: all` stands."""
    node = draft.given["determined"][1] if "determined" in draft.given else None
    return node.place if isinstance(node, Scalar) and node.text == "all" else None


def _detectable(draft: ClaimDraft, problems: Problems) -> tuple[bool, Place] | None:
    """Return what is said of detectability, and where."""
    if "detectable" not in draft.given:
        return None
    node = draft.given["detectable"][1]
    word = choice_of(draft.given["detectable"], f"{draft.path}.detectable", ("true", "false"), problems)
    return (word == "true", node.place) if word else None


def _together(draft: ClaimDraft, states: Sequence[State], problems: Problems) -> dict[str, tuple[str, Place]]:
    """Return the verdicts on states under `determined` and `states`, which must not contradict each other."""
    determined, verdicts = _determined(draft, states, problems), _verdicts(draft, states, problems)
    for name in determined.keys() & verdicts.keys():
        if verdicts[name][0] != "observable":
            message = f"'{name}' is {verdicts[name][0]} here, and determined above"
            problems.add(draft.given["states"][1].problem(f"{draft.path}.states", message))
    return {**determined, **verdicts}


def _determined(
    draft: ClaimDraft, states: Sequence[State], problems: Problems
) -> dict[str, tuple[str, Place]]:
    """Return the states under `determined` as observable ones."""
    if "determined" not in draft.given:
        return {}
    node = draft.given["determined"][1]
    if _everything(draft) is not None:
        everyone = () if draft.experiment else states
        return {state.name: ("observable", node.place) for state in everyone}
    path = f"{draft.path}.determined"
    result: dict[str, tuple[str, Place]] = {}
    for item in items_of(node, path, problems):
        name = item.text if isinstance(item, Scalar) else ""
        found = _named(name, item, path, states, problems)
        result.update(dict.fromkeys(found, ("observable", item.place)))
    return result


def _named(name: str, node: Node, path: str, states: Sequence[State], problems: Problems) -> list[str]:
    """Return the states of a name: one, or those of a vector; an unknown one is reported."""
    found = [state.name for state in states if name and name in (state.name, state.vector)]
    if not found and not isinstance(node, Broken):
        known = [spelling for state in states for spelling in (state.name, state.vector) if spelling]
        problems.add(node.problem(path, f"'{shown(name)}' is no state{nearest(name, known)}"))
    return found


def _label(item: Formula) -> str:
    return item.text or flow_text(item.node)


def _values(
    draft: ClaimDraft, scope: Scope, problems: Problems
) -> Mapping[str, Expression] | Literal["nominal"] | None:
    if draft.at is None or draft.at == "nominal":
        return draft.at
    parameters = [
        n for n, v in scope.values.items() if v.is_scalar and isinstance(v.entries[0].constant, Symbol)
    ]
    result = {}
    for name, (key, value) in draft.at.items():
        if name not in scope.values or scope.values[name].entries[0].linear:
            message = f"'{shown(name)}' is no parameter{nearest(name, parameters)}"
            problems.add(key.problem(f"{draft.path}.at", message))
            continue
        node = constant(value, scope, problems)
        if node is not None:
            result[name] = node
    return result


def _directions(
    draft: ClaimDraft, scope: Scope, states: Sequence[State], problems: Problems
) -> Iterator[Quantity]:
    names = {state.name for state in states}
    for k, (item, components) in enumerate(draft.directions, start=1):
        found: dict[str, Expression] = {}
        for name, (key, value) in components.items():
            node = constant(value, scope, problems)
            if name not in names:
                message = f"'{shown(name)}' is no state{nearest(name, names)}"
                problems.add(key.problem(f"{draft.path}.directions[{k}]", message))
            elif node is not None and not is_zero(node):
                found[name] = node
        yield Quantity(f"directions[{k}]", found, item.place, flow_text(item))


def _verdicts(draft: ClaimDraft, states: Sequence[State], problems: Problems) -> dict[str, tuple[str, Place]]:
    if "states" not in draft.given:
        return {}
    path = f"{draft.path}.states"
    result: dict[str, tuple[str, Place]] = {}
    for name, (key, value) in fields(draft.given["states"][1], path, None, problems).items():
        verdict = choice_of((key, value), f"{path}.{name}", VERDICTS, problems)
        found = _named(name, key, path, states, problems)
        if verdict:
            result.update(dict.fromkeys(found, (verdict, value.place)))
    return result


def about_segments(
    drafts: tuple[ClaimDraft, ...], problems: Problems, *, there: bool
) -> tuple[ClaimDraft, ...]:
    """Return the claims about the segments together; without any ``there`` they are reported."""
    found = tuple(one for one in drafts if one.segments)
    for draft in () if there else found:
        problems.add(draft.given["segments"][0].problem(draft.path, "there are no `segments` in this file"))
    return found


def about_experiment(
    drafts: tuple[ClaimDraft, ...], experiment: Experiment | None, problems: Problems
) -> tuple[ClaimDraft, ...]:
    """Return the claims about the experiment, told what runs there are; one about another is reported."""
    found = []
    for draft in drafts:
        if not draft.experiment:
            continue
        if draft.stage:
            key = draft.given["stage"][0]
            problems.add(key.problem(draft.path, "`stage` and `experiment` are both given; one of the two"))
        name = experiment.name if experiment else ""
        if name and draft.experiment != name:
            message = f"there is no experiment '{shown(draft.experiment)}'{nearest(draft.experiment, [name])}"
            node = draft.given["experiment"][1]
            problems.add(node.problem(f"{draft.path}.experiment", message, f"it is named {name}"))
        runs = None if experiment is None else tuple(run.name for run in experiment.everything)
        found.append(replace(draft, known=runs))
    return tuple(found)
