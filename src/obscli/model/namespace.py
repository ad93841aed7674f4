"""One namespace for everything an expression can name; a clash is told with both places."""

from __future__ import annotations

from collections.abc import Iterator

from obscli.model.declaration import Declared
from obscli.model.draft import Draft
from obscli.model.tree import Scalar
from obscli.model.trouble import Problems, shown


def check_namespace(draft: Draft, problems: Problems) -> None:
    """Report names (and names of components) that are given twice."""
    seen: dict[str, tuple[str, str, Scalar | None]] = {}
    for name, section, what, key in _all_names(draft):
        if name not in seen:
            seen[name] = (section, what, key)
            continue
        _, earlier, first = seen[name]
        where = f" in line {first.line}" if first is not None else ""
        message = f"the name '{shown(name)}' is taken: it is {earlier}{where}, and here {what}"
        culprit = key if key is not None else first
        if culprit is not None:
            problems.add(culprit.problem(section, message, "all names share one namespace; rename one"))


def _all_names(draft: Draft) -> Iterator[tuple[str, str, str, Scalar | None]]:
    """Yield name, section, what it is, where it stands, in the order of precedence."""
    yield draft.time or "t", "time", "the time symbol", draft.time_key
    for name, parameter in draft.parameters.items():
        yield name, "parameters", "a parameter", parameter.key
    sections = {
        "functions": ("a function of time", _functions(draft, implied=False)),
        "signals": ("a signal", _functions(draft, implied=True)),
        "states": ("a state", draft.states),
        "inputs": ("an input", draft.inputs),
        "disturbances": ("a disturbance", draft.disturbances),
    }
    for section, (what, group) in sections.items():
        for one in group:
            yield from _names_of(one, section, what)
    for name, entry in draft.let.items():
        yield name, "let", "a `let` entry", entry.key
    states = {name for one in draft.states for name in (one.name, *one.components)}
    for name, entry in draft.quantities.items():
        if name in states:
            yield name, "quantities", "a quantity", entry.key


def _functions(draft: Draft, *, implied: bool) -> tuple[Declared, ...]:
    return tuple(one.declared for one in draft.functions if one.implied == implied)


def _names_of(one: Declared, section: str, what: str) -> Iterator[tuple[str, str, str, Scalar]]:
    yield one.name, section, what, one.key
    if one.shape:
        for component in one.components:
            yield component, section, f"{what} (a component of {one.name})", one.key
