"""The variants of a file: the base, where it is complete by itself, and every stage."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Final

from obscli.core.place import Place, Problem
from obscli.model.claims import ClaimDraft
from obscli.model.discrete import check_discrete
from obscli.model.draft import Draft, Entries, Entry, merged
from obscli.model.elaborate import Setting, elaborate
from obscli.model.experiment import RunDraft
from obscli.model.formula import Formula, times_matrix
from obscli.model.keys import fields
from obscli.model.meter import Meter
from obscli.model.sections import STAGE_KEYS, read_draft
from obscli.model.system import System
from obscli.model.tokens import LONGEST_NAME
from obscli.model.tree import Node
from obscli.model.trouble import Problems, is_printable, nearest, shown


MOST_STAGES: Final = 500


def read_stages(node: Node | None, problems: Problems) -> dict[str, Draft]:
    """Read the replacements of every stage."""
    stages = {}
    for name, (key, value) in fields(node, "stages", None, problems).items():
        if not name.strip() or len(name) > LONGEST_NAME or not all(map(is_printable, name)):
            message = f"'{shown(name)}' is no name of a stage: one line of at most {LONGEST_NAME} characters"
            problems.add(key.problem("stages", message))
        stages[name] = read_draft(value, f"stages.{name}", STAGE_KEYS, problems)
    return stages


@dataclass(frozen=True, slots=True, eq=False)
class Variants:
    """A base, its stages, what the command line changes in all of them; ``told``: problems found so far."""

    base: Draft
    stages: Mapping[str, Draft]
    settings: Draft
    fix: Entries
    claims: tuple[ClaimDraft, ...]
    told: set[tuple[Place, str]] = field(default_factory=set)

    def elaborate(self, problems: Problems) -> tuple[System, ...]:
        """Return the systems, the base first unless a stage equals it or it is incomplete."""
        _check_forms(self.base, "", problems)
        check_discrete(self.base, self.stages, problems)
        for stage_name, stage in self.stages.items():
            self._check_replaced(f"stages.{stage_name}", stage, problems)
        names: list[str | None] = list(self.stages)
        if not any(stage.is_empty for stage in self.stages.values()):
            names.insert(0, None)
        if len(names) > MOST_STAGES:
            message = f"{len(names)} stages; at most {MOST_STAGES} are read"
            problems.add(self.base.node.problem("stages", message, "make the file several files"))
            return ()
        elsewhere, meter, sound = self._elsewhere(), Meter(), not problems
        systems: list[System] = []
        found: dict[tuple[object, ...], tuple[Problem, list[str | None]]] = {}
        for name in names:
            is_base = name is None and bool(self.stages)
            setting = Setting(name, is_base, sound, self.fix, elsewhere, self.claims, meter)
            here = Problems()
            system = elaborate(merged(self._draft(name), self.settings), setting, here)
            systems += [] if system is None else [system]
            for problem in here:
                found.setdefault((problem.place, problem.message), (problem, []))[1].append(name)
            if meter.is_exhausted:
                break
        self.told.update((problem.place, problem.message) for problem, _ in found.values())
        for problem, where in found.values():
            problems.add(_attributed(problem, where, len(names)))
        return tuple(systems)

    def run(self, run: RunDraft, meter: Meter, problems: Problems) -> System | None:
        """Return the system of a run; None where it is wrong, which is reported with the run's name."""
        self._check_replaced(run.path, run.change, problems)
        if meter.is_exhausted:
            return None
        setting = Setting(run.name, False, True, self.fix, self._elsewhere(), (), meter, run)  # noqa: FBT003
        here = Problems()
        changed = merged(merged(self._draft(run.stage), replace(run.change, fix={})), self.settings)
        if run.turn is not None:
            changed = _turned(changed, *run.turn)
        system = elaborate(changed, setting, here)
        for problem in here:
            place = (problem.place, problem.message)
            if place not in self.told:  # by a stage, or by another run
                self.told.add(place)
                problems.add(replace(problem, message=f"{problem.message} (in run '{shown(run.name)}')"))
        return system

    def _draft(self, name: str | None) -> Draft:
        return self.base if name is None else merged(self.base, self.stages[name])

    def _elsewhere(self) -> dict[str, str]:
        """Return the ``let`` names without a value in the base, with the stages that give one."""
        users: dict[str, list[str]] = {}
        for stage, one in self.stages.items():
            for name in one.let:
                if name not in self.base.let or self.base.let[name].formula is None:
                    users.setdefault(name, []).append(stage)
        return {name: ", ".join(f"'{shown(stage)}'" for stage in names[:3]) for name, names in users.items()}

    def _check_replaced(self, name: str, stage: Draft, problems: Problems) -> None:
        """Report parameters of a stage that the base does not have, and names that clash."""
        for parameter, given in stage.parameters.items():
            if parameter not in self.base.parameters:
                message = f"'{shown(parameter)}' is no parameter of the file"
                hint = nearest(parameter, self.base.parameters)
                problems.add(given.key.problem(f"{name}.parameters", message + hint))
        _check_forms(stage, name, problems)
        taken = {one.name: "a state" for one in self.base.states}
        taken |= dict.fromkeys(self.base.parameters, "a parameter")
        taken |= {one.declared.name: "a function" for one in (*self.base.functions, *stage.functions)}
        taken[self.base.time or "t"] = "the time"
        for entry, given_entry in stage.let.items():
            if entry in taken:
                message = f"the name '{shown(entry)}' is taken: it is {taken[entry]}"
                problems.add(given_entry.key.problem(f"{name}.let", message))


def _turned(draft: Draft, name: str, matrix: Formula) -> Draft:
    """Return the draft with a value of ``let`` multiplied by a matrix from the right."""
    entry = draft.let.get(name)
    if entry is None or entry.formula is None:
        return draft
    return replace(draft, let={**draft.let, name: Entry(entry.key, times_matrix(entry.formula, matrix))})


def _check_forms(draft: Draft, path: str, problems: Problems) -> None:
    """Report a matrix given beside the equations it stands for."""
    for matrix, sides, given in (
        ("A", "dynamics", draft.dynamics),
        ("H", "measurements", draft.measurements),
    ):
        if matrix in draft.matrices and given is not None:
            message = f"`{matrix}` and `{sides}` are both given; one of the two"
            problems.add(draft.matrices[matrix].node.problem(path, message))


def _attributed(problem: Problem, stages: list[str | None], variants: int) -> Problem:
    """Say in which stages a problem arises, where it does not in all."""
    if len(stages) == variants:
        return problem
    names = ", ".join("the base" if stage is None else f"stage '{shown(stage)}'" for stage in stages[:3])
    return replace(problem, message=f"{problem.message} (in {names})")
