"""Check of ``experiment``: runs that share constant states; kept for the command that uses it."""

from __future__ import annotations

from collections.abc import Collection
from typing import Final

from obscli.model.formula import formula
from obscli.model.keys import fields, items_of, whole_of
from obscli.model.plain import plain
from obscli.model.system import Plain
from obscli.model.tree import Broken, Mapping, Node, Scalar
from obscli.model.trouble import Problems, nearest, shown


EXPERIMENT_KEYS: Final = ("runs", "constant", "fresh", "name", "description")
RUN_KEYS: Final = ("stage", "name", "fix", "interval", "repeat", "grid")


def kept_experiment(
    node: Node | None,
    stages: Collection[str],
    states: Collection[str],
    fixable: Collection[str],
    problems: Problems,
) -> Plain | None:
    """Return the experiment checked: names of stages, states, parameters; expressions parsed.

    Parameters
    ----------
    fixable : names of parameters and functions
    """
    if node is None or isinstance(node, Broken):
        return None
    given = fields(node, "experiment", EXPERIMENT_KEYS, problems)
    if "runs" in given:
        runs = items_of(given["runs"][1], "experiment.runs", problems)
        for k, run in enumerate(runs, start=1):
            _check_run(run, f"experiment.runs[{k}]", stages, fixable, problems)
    for key in ("constant", "fresh"):
        if key in given:
            for item in items_of(given[key][1], f"experiment.{key}", problems):
                _check_name(item, f"experiment.{key}", states, "state", problems)
    return plain(node)


def _check_name(node: Node, path: str, known: Collection[str], what: str, problems: Problems) -> None:
    name = node.text if isinstance(node, Scalar) else ""
    if name not in known and not isinstance(node, Broken):
        problems.add(node.problem(path, f"there is no {what} '{shown(name)}'{nearest(name, known)}"))


def _check_run(
    run: Node, path: str, stages: Collection[str], fixable: Collection[str], problems: Problems
) -> None:
    if not isinstance(run, Mapping):
        _check_name(run, path, stages, "stage", problems)
        return
    given = fields(run, path, RUN_KEYS, problems)
    if "stage" in given:
        _check_name(given["stage"][1], f"{path}.stage", stages, "stage", problems)
    if "repeat" in given:
        whole_of(given["repeat"][1], f"{path}.repeat", problems)
    if "interval" in given:
        _check_interval(given["interval"][1], f"{path}.interval", problems)
    for key in ("fix", "grid"):
        below = f"{path}.{key}"
        entries = fields(given[key][1], below, None, problems) if key in given else {}
        for name, (word, value) in entries.items():
            _check_name(word, below, fixable, "parameter or function", problems)
            for item in (value,) if key == "fix" else items_of(value, f"{below}.{name}", problems):
                formula(item, f"{below}.{name}", problems)


def _check_interval(node: Node, path: str, problems: Problems) -> None:
    for key, (_, value) in fields(node, path, ("start", "stop", "samples"), problems).items():
        formula(value, f"{path}.{key}", problems)
