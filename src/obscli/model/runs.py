"""Runs as systems, the states they share, and what is asked for: ``experiment``, ``plan``, ``require``."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from collections.abc import Mapping as MappingOf
from dataclasses import replace
from fractions import Fraction
from typing import TypeAlias

from obscli.model.constant import constant
from obscli.model.covector import scope_of
from obscli.model.declaration import is_part_of
from obscli.model.evaluate import evaluate
from obscli.model.experiment import ExperimentDraft, PlanDraft, RunDraft
from obscli.model.expression import ONE, Expression, symbols
from obscli.model.formula import formula
from obscli.model.keys import fields
from obscli.model.sign import sign_at_nominal
from obscli.model.source import checked
from obscli.model.system import Experiment, Planning, Requirement, Run, System
from obscli.model.tree import Broken, Mapping, Node, Scalar, kind
from obscli.model.tree import Sequence as SequenceNode
from obscli.model.trouble import Problems, nearest, shown


#: Makes the system of a run; None where it is wrong.
Elaborated: TypeAlias = Callable[[RunDraft, Problems], System | None]


def experiment_of(
    draft: ExperimentDraft | None, plan: PlanDraft | None, elaborated: Elaborated, problems: Problems
) -> Experiment | None:
    """Return the runs of a file with the states they share; None where there are none."""
    if draft is None and (plan is None or plan.candidates is None):
        if plan is not None:
            message = "there is nothing to choose from: give `candidates`, or an `experiment`"
            problems.add(plan.node.problem("plan", message))
        return None
    runs = _runs(draft.runs if draft else (), elaborated, problems)
    candidates = None
    if plan is not None and plan.candidates is not None:
        candidates = _runs(plan.candidates, elaborated, problems)
    chosen_from = (plan and plan.candidates) or (draft.runs if draft else ())
    everything = (*runs, *(candidates or ()))
    if problems or not everything:
        return None
    return Experiment(
        draft.name if draft else "",
        draft.description if draft else "",
        runs,
        shared_states(tuple(run.system for run in everything), draft, problems),
        None if plan is None else _planning(plan, chosen_from, candidates or runs, candidates, problems),
    )


def _runs(drafts: tuple[RunDraft, ...], elaborated: Elaborated, problems: Problems) -> tuple[Run, ...]:
    """Return the runs; those that differ by their number only share one system."""
    known: dict[tuple[int, str | None], System | None] = {}
    found = []
    for draft in drafts:
        key = (id(draft.fix), draft.stage)
        if key not in known:
            known[key] = elaborated(draft, problems)
        system = known[key]
        if system is not None:
            turned, freed = _turned(draft, elaborated), _freed(draft, elaborated)
            place, fixed = draft.node.place, tuple(draft.fix)
            found.append(Run(draft.name, system, draft.stage, place, turned, fixed, freed))
    return tuple(found)


def _freed(draft: RunDraft, elaborated: Elaborated) -> Callable[[str], System | None]:
    def freed(name: str) -> System | None:
        problems = Problems()
        fix = {one: entry for one, entry in draft.fix.items() if one != name}
        system = elaborated(replace(draft, fix=fix), problems)
        return None if problems else system

    return freed


def _turned(draft: RunDraft, elaborated: Elaborated) -> Callable[[str, str], System | None]:
    def turned(name: str, matrix: str) -> System | None:
        problems = Problems()
        factor = formula(Scalar(checked(matrix, name), 1, 1, matrix, matrix), "", problems)
        system = elaborated(replace(draft, turn=(name, factor)), problems)
        return None if problems else system

    return turned


def shared_states(
    systems: Sequence[System], draft: ExperimentDraft | None, problems: Problems
) -> tuple[str, ...]:
    """Return the states that all runs share, in order: those asked for, else all that stand still."""
    moving = {name for system in systems for name in _moving(system)}
    states = systems[0].states
    if draft is not None and draft.constant is not None:
        return tuple(_asked_for(draft.constant, systems, moving, problems))
    fresh = {item.text for item in draft.fresh} if draft else set()
    return tuple(one.name for one in states if one.name not in moving and not {one.name, one.vector} & fresh)


def _asked_for(
    wanted: Sequence[Scalar], systems: Sequence[System], moving: Collection[str], problems: Problems
) -> Iterator[str]:
    names = {item.text: item for item in wanted}
    for one in systems[0].states:
        item = names.get(one.name) or names.get(one.vector)
        if item is None:
            continue
        if one.name in moving:
            where = shown(next(run for run in systems if one.name in _moving(run)).stage or "")
            message = f"'{one.name}' is not constant: its derivative is not zero in run '{where}'"
            hint = "only what keeps its value can be shared by runs; leave it out"
            problems.add(item.problem("experiment.constant", message, hint))
        yield one.name


def _moving(system: System) -> Iterator[str]:
    """Yield the states whose derivative is not identically zero."""
    rows = {i for matrix in (system.A, system.B, system.G) if matrix is not None for i, _ in matrix.entries}
    yield from (system.states[i].name for i in sorted(rows))


def _planning(
    plan: PlanDraft,
    drafts: Sequence[RunDraft],
    chosen_from: tuple[Run, ...],
    candidates: tuple[Run, ...] | None,
    problems: Problems,
) -> Planning:
    forbidden = tuple(some for node in plan.forbidden for some in _forbidden(node, drafts, problems))
    setup = None
    if plan.setup_time is not None and chosen_from:
        system = chosen_from[0].system
        setup = constant(plan.setup_time, scope_of(system), problems)
        if setup is not None and (sign_at_nominal(setup, system) == -1 or _moves(setup, system)):
            problems.add(plan.setup_time.problem("a time is expected here: zero or a positive number"))
    return Planning(candidates, forbidden, setup)


def _forbidden(node: Node, drafts: Sequence[RunDraft], problems: Problems) -> Iterator[tuple[str, ...]]:
    """Yield what an entry of ``forbidden`` forbids: candidates with some values, one, or several together."""
    if not isinstance(node, Mapping):
        names = tuple(_names_in(node, [draft.name for draft in drafts], problems))
        yield from (names,) if names else ()
        return
    wanted = {key.text: _canonical(value.text) for key, value in node.entries if isinstance(value, Scalar)}
    found = [draft.name for draft in drafts if len(wanted) == len(node.entries) and _has(draft, wanted)]
    if not found:
        known = sorted({name for draft in drafts for name in draft.fix} | {"stage"})
        hint = f"give values as the candidates have them, of {', '.join(known)}: {{stage: up, omega: -omega}}"
        problems.add(node.problem("plan.forbidden", "no candidate has these values", hint))
    yield from ((name,) for name in found)


def _has(draft: RunDraft, wanted: MappingOf[str, str]) -> bool:
    """Whether a candidate has all the values: of ``stage``, and of what it fixes."""
    values = {name: _canonical(entry.formula.text) for name, entry in draft.fix.items() if entry.formula}
    values["stage"] = _canonical(draft.stage or "")
    return all(values.get(name) == text for name, text in wanted.items())


def _canonical(text: str) -> str:
    """Return a number as a fraction, so that 0.5 is 1/2; other expressions without blanks."""
    together = "".join(text.split())
    try:
        return str(Fraction(together))
    except (ValueError, ZeroDivisionError):
        return together


def _names_in(node: Node, known: Sequence[str], problems: Problems) -> Iterator[str]:
    """Yield the candidates an entry of ``forbidden`` names: one, or several not to be taken together."""
    if isinstance(node, Broken):
        return
    items = node.items if isinstance(node, SequenceNode) else (node,)
    if not items:
        problems.add(node.problem("plan.forbidden", "the list is empty"))
    for item in items:
        if not isinstance(item, Scalar):
            message = f"the name of a candidate is expected here, not {kind(item)}"
            problems.add(item.problem("plan.forbidden", message))
            continue
        name = item.text
        if name not in known:
            hint = f"there are: {', '.join(known[:8])}" + (", …" if len(known) > 8 else "")
            message = f"there is no candidate '{shown(name)}'{nearest(name, known)}"
            problems.add(item.problem("plan.forbidden", message, hint))
        yield name


def requirements(
    node: Node | None, system: System, names: Collection[str], problems: Problems
) -> tuple[Requirement, ...]:
    """Return the accuracy asked for, by state and quantity; a vector's value holds for every component."""
    if node is None or isinstance(node, Broken):
        return ()
    found: list[Requirement] = []
    scope = scope_of(system)
    for name, (key, value) in fields(node, "require", None, problems).items():
        if name not in names:
            message = f"'{shown(name)}' is none of the names expected here{nearest(name, names)}"
            problems.add(key.problem("require", message))
        if isinstance(value, Scalar) and value.is_null:
            problems.add(value.problem(f"require.{name}", "an expression is missing here"))
            continue
        if isinstance(value, Mapping):
            problems.add(value.problem(f"require.{name}", "an expression is expected here, not a mapping"))
            continue
        asked = evaluate(formula(value, f"require.{name}", problems), scope, problems)
        targets = [
            *((one.name, {one.name: ONE}) for one in system.states if name in (one.name, one.vector)),
            *(
                (one.name, one.coefficients)
                for one in system.quantities
                if one.name == name or (one.name not in names and is_part_of(one.name, name))
            ),
        ]
        if asked is None:
            continue
        if not asked.is_scalar and len(asked.entries) != len(targets):
            message = f"{len(targets)} values are expected here (or one for all), not {len(asked.entries)}"
            problems.add(value.problem(f"require.{name}", message))
            continue
        entries = asked.entries * (len(targets) if asked.is_scalar else 1)
        for (target, covector), entry in zip(targets, entries, strict=True):
            asked_for = entry.constant
            if entry.linear or sign_at_nominal(asked_for, system) in {0, -1} or _moves(asked_for, system):
                message = "a positive number is expected here: one standard deviation"
                problems.add(value.problem(f"require.{name}", message))
                break
            if target in {one.name for one in found}:
                problems.add(key.problem("require", f"'{target}' is required twice"))
            found.append(Requirement(target, covector, asked_for, key.place))
    return tuple(found)


def _moves(value: Expression, system: System) -> bool:
    """Whether the value depends on time."""
    return bool(symbols(value) & {system.time, *(one.name for one in system.functions)})
