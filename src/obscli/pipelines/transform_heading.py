"""What stands above a model that comes of another: where it comes from, and the way back to its states."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from obscli.core.number import counted
from obscli.exact.reduced import StateBack
from obscli.model.expression import Expression
from obscli.model.notation import covector_text
from obscli.model.system import Covector, Model, System
from obscli.model.variables import is_state
from obscli.model.write import Heading
from obscli.pipelines.request import Changes, Target


_PARTS: Final[dict[Target, str]] = {
    "observable": "observable part",
    "kalman": "Kalman decomposition",
    "stationary": "stationary form",
    "drop": "without the states that cannot be estimated",
}
_OPTIONS: Final[dict[Target, str]] = {
    "observable": "--to observable",
    "kalman": "--to kalman",
    "stationary": "--to stationary",
    "drop": "--drop",
}


def heading(
    model: Model, system: System, to: Target, description: str, comments: Sequence[str], rank: int
) -> Heading:
    """Return name, title, description and source of a model made of a stage of another, with its rank."""
    stage = f", stage {system.stage}" if system.stage else ""
    made = f"Made by obscli transform {_OPTIONS[to]} of the model {model.name}{stage}."
    name = "_".join(part for part in (model.name, system.stage, to) if part)
    title = f"{model.title or model.name}{stage} ({_PARTS[to]})"
    return Heading(name, title, description, model.source, (made, *comments), rank)


def changed(changes: Changes) -> Iterator[str]:
    """Yield a comment where the model was changed while it was read."""
    made = [f"--set {name}={value}" for name, value in changes.settings.items()]
    made += [f"--fix {name}={value}" for name, value in changes.fix.items()]
    made += [f"--outputs {','.join(changes.outputs)}"] if changes.outputs else []
    made += [f"--without {','.join(changes.without)}"] if changes.without else []
    if made:
        yield f"Changed before: {' '.join(made)}"


def observable_words(system: System, kept: int) -> str:
    """Describe the model in the observable combinations."""
    return (
        f"The {counted(kept, 'observable combination')} z = S x of {counted(system.n, 'state')}: all outputs "
        "are the same as there, and all of z is observable. What no output shows is left out. The comments "
        "above say how the states of that model come back."
    )


def kalman_words(sizes: Sequence[int], by: str | None) -> str:
    """Describe the model in the coordinates of the Kalman decomposition."""
    if by is None:
        return (
            f"Coordinates in which what no output shows stands apart: first {counted(sizes[0], 'state')}, "
            f"all observable, then {sizes[1]} that no output shows and that move none of the first."
        )
    a, b, c, d = sizes
    return (
        f"Coordinates of the Kalman decomposition by {by}: first {counted(a, 'state')} reachable and not "
        f"observable, then {b} reachable and observable, {c} neither, {d} observable and not reachable."
    )


def stationary_words(system: System, size: int) -> str:
    """Describe the stationary system."""
    return (
        f"{counted(size, 'time-invariant equation')} instead of {system.n} that depend on time: z = V(t) x, "
        "and every output is the same. The comments above say what z is; it starts from z = V(t0) x."
    )


def drop_words(dropped: Sequence[str], *, is_exact: bool) -> str:
    """Describe the model without the states that cannot be estimated."""
    if not dropped:
        return "All states can be estimated: nothing is dropped."
    truth = (
        "The model is exact even if that is wrong, for what its states then stand for: a state may stand for "
        "more than itself."
        if is_exact
        else "The model is exact only as far as that is true at all times."
    )
    return f"Assumes {' = '.join(dropped)} = 0, which no output tells apart from the others. {truth}"


def way_back(names: Sequence[str], back: Mapping[str, StateBack], free: Sequence[str]) -> Iterator[str]:
    """Yield the states of the old model in those of the new one, for the comments."""
    lines = list(back_lines(names, back))
    if free:
        yield f"No output shows anything of these, which may have any values: {', '.join(free)}."
    if lines:
        yield "With them the other states of that model are" if free else "The states of that model are"
        yield from (f"  {line}" for line in lines)


def back_lines(names: Sequence[str], back: Mapping[str, StateBack]) -> Iterator[str]:
    """Yield ``psi2 = 1/g*z_psi2 + 1/g*b_a1`` for each state that is not itself a state of the new model."""
    for state, form in back_forms(names, back).items():
        if not is_state(form) or next(iter(form)) != state:
            yield f"{state} = {covector_text(form, list(form))}"


def back_forms(names: Sequence[str], back: Mapping[str, StateBack]) -> dict[str, Covector]:
    """Return each state as a linear form in the new states and the free ones."""
    found: dict[str, Covector] = {}
    for state, parts in back.items():
        new: dict[str, Expression] = {names[k]: entry for k, entry in parts.variables.items()}
        found[state] = {**new, **parts.free}
    return found


def assumption(dropped: Sequence[str], moved: Sequence[str], *, is_exact: bool) -> Iterator[str]:
    """Yield what leaving states out assumes, for the comments."""
    if dropped:
        yield f"Dropped, as if zero: {', '.join(dropped)}."
    if moved and not is_exact:
        yield f"They do not stay zero, other states move them: {', '.join(moved)}."


def meanings(system: System, names: Sequence[str], forms: Sequence[Covector]) -> Iterator[str]:
    """Yield ``psi2: psi2 - 1/g*b_a1`` for each state that stands for more than itself, for the comments."""
    lines = [
        f"  {name}: {covector_text(form, system.state_names)}"
        for name, form in zip(names, forms, strict=True)
        if not is_state(form)
    ]
    if lines:
        yield "States that stand for more than themselves:"
        yield from lines
