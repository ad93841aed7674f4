"""Discrete-time models, x(k+1) = F(k) x(k), y(k) = H(k) x(k): what goes with `F`, and who takes them.

    L_0 = H,   L_{j+1}(k) = L_j(k+1) F(k)

The shift takes the place of the derivation. For constant F and H this is the matrix [H; H F; H F²; …], that
of a continuous-time system with F for A: whoever needs ranks, combinations and directions of constant
coefficients only reads F as A. Whoever moves states in time asks which it is.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

from obscli.core.place import ModelError, Problem
from obscli.model.constant import constant
from obscli.model.draft import Draft
from obscli.model.environment import Environment
from obscli.model.expression import Apply, Expression, Pi, postorder, symbols
from obscli.model.formula import formula
from obscli.model.keys import Fields
from obscli.model.sign import sign
from obscli.model.system import Noise, System
from obscli.model.tree import Broken, Node
from obscli.model.trouble import Problems


#: The time symbol of discrete-time models where the file gives none.
INDEX: Final = "k"

#: What is refused beside `F`, by key, and what to do instead.
_INSTEAD: Final = {
    "A": "`A` is the matrix of x' = A x, `F` that of x(k+1) = F x(k): one of the two",
    "dynamics": "`dynamics` are right-hand sides of x': write the matrix `F` alone",
    "linearize": "give the Jacobians as `F` and `H`",
    "functions": "write the function in terms of the step k under `let`",
}
#: Functions whose values at constants may be multiples of π.
_INVERSE: Final = frozenset({"asin", "acos", "atan"})

#: Keys of experiments, which are put together of runs in continuous time.
_RUNS: Final = ("experiment", "plan")


def with_index(draft: Draft, stages: Mapping[str, Draft], given: Fields, problems: Problems) -> Draft:
    """Return the base of a file with the time symbol k where it is a discrete-time model without one.

    Parameters
    ----------
    given : the keys of the file, of which those that are for continuous time are reported
    """
    if not any(one.is_discrete for one in (draft, *stages.values())):
        return draft
    for key in _RUNS:
        if key in given:
            message = f"`{key}` of a discrete-time model (`F`) is not supported yet"
            problems.add(given[key][0].problem("", message, "give the runs as models of their own"))
    return draft.indexed(INDEX)


def check_discrete(base: Draft, stages: Mapping[str, Draft], problems: Problems) -> None:
    """Report what cannot stand beside `F`, and a file that is of both kinds."""
    drafts = {"": base, **{f"stages.{name}": stage for name, stage in stages.items()}}
    if not any(one.is_discrete for one in drafts.values()):
        for path, draft in drafts.items():
            if draft.step is not None:
                hint = "the time between samples stands under `noise` or `outputs`"
                problems.add(draft.step.problem(path, "`step` goes with `F`, of a discrete-time model", hint))
        return
    for path, draft in drafts.items():
        for key, node in _continuous(draft):
            what = "goes with continuous time" if key != "functions" else "is not supported yet"
            problems.add(
                node.problem(path, f"`{key}` {what}; this is a discrete-time model (`F`)", _INSTEAD[key])
            )


def _continuous(draft: Draft) -> Iterator[tuple[str, Node]]:
    """Yield the sections of a draft that go with continuous time."""
    if "A" in draft.matrices:
        yield "A", draft.matrices["A"].node
    for entry in (draft.dynamics or {}).values():
        yield "dynamics", entry.key
        break
    for function in draft.functions:
        yield "functions", function.declared.key
        break
    for entry in (draft.linearize or {}).values():
        yield "linearize", entry.key
        break


def check_noise(draft: Draft, noise: Noise | None, problems: Problems) -> None:
    """Report a time between samples where samples are counted in steps."""
    if draft.is_discrete and noise is not None and noise.step is not None:
        hint = (
            "R is the covariance of a sample, Q of what enters in a step; `every` of an output counts steps"
        )
        problems.add(
            Problem(noise.place, "noise.step", "a discrete-time model (`F`) has its own `step`", hint)
        )


def step_of(draft: Draft, known: Environment, problems: Problems) -> Expression | None:
    """Return the seconds from one step to the next, None where the file does not say."""
    if draft.step is None or isinstance(draft.step, Broken) or not draft.is_discrete:
        return None
    found = constant(formula(draft.step, "step", problems), known.scope, problems)
    if found is not None and sign(found) in {0, -1}:
        problems.add(draft.step.problem("step", "a positive time is expected here"))
    if found is not None and draft.time in symbols(found):
        problems.add(draft.step.problem("step", f"the step depends on {draft.time}: it is one number"))
    return found


def is_time_invariant(system: System) -> bool:
    """Whether neither the dynamics nor the outputs vary in time."""
    return varying_entry(system) is None


def varying_entry(system: System) -> str | None:
    """Return where the first coefficient that depends on time stands, and its name; None: none does."""
    moving = {system.time} | {one.name for one in system.functions}
    return next((where for entry, where in _entries(system) if moving & symbols(entry)), None)


def repeating_entry(system: System) -> str | None:
    """Return where a coefficient contains a function of a multiple of π times the step; None: none does."""
    for entry, where in _entries(system):
        if any(_may_repeat(node, system.time) for node in postorder(entry)):
            return where
    return None


def _may_repeat(node: Expression, step: str) -> bool:
    """Whether a node is a function of an argument with the step and what may be π."""
    if not isinstance(node, Apply) or step not in symbols(node.argument):
        return False
    return any(map(_may_be_pi, postorder(node.argument)))


def _may_be_pi(node: Expression) -> bool:
    """Whether a node is π, or an inverse function, whose values are multiples of it."""
    return isinstance(node, Pi) or (isinstance(node, Apply) and node.function in _INVERSE)


def _entries(system: System) -> Iterator[tuple[Expression, str]]:
    """Yield the coefficients of the dynamics and the outputs, row by row, and the place of each."""
    names = {"H": tuple(one.name for one in system.outputs), system.dynamics_name: system.state_names}
    for key, matrix in ((system.dynamics_name, system.A), ("H", system.H)):
        for (i, j), entry in sorted(matrix.entries.items()):
            place = matrix.places.get((i, j))
            yield entry, f"{f'{place}: ' if place else ''}{key}[{names[key][i]}, {system.state_names[j]}]"


def require_continuous(system: System, what: str, hint: str = "") -> None:
    """Refuse a discrete-time system.

    Parameters
    ----------
    what : who takes continuous-time models only: the subject of the message
    hint : what to do instead

    Raises
    ------
    ModelError
        where the system is a discrete-time one; with the place of its `F`
    """
    if system.discrete:
        place = next(iter(system.A.places.values()), system.states[0].place)
        raise ModelError([Problem(place, "F", f"{what} does not take discrete-time models yet", hint)])
