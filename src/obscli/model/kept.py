"""Checks of what is kept for later commands: ``noise``, ``interval``, ``require``."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Final

from obscli.model.constant import constant
from obscli.model.evaluate import evaluate
from obscli.model.expression import Expression
from obscli.model.formula import formula
from obscli.model.keys import fields, whole_of
from obscli.model.plain import plain
from obscli.model.scope import Scope
from obscli.model.system import Interval, Plain
from obscli.model.tensor import Tensor, named
from obscli.model.tree import Broken, Mapping, Node, Scalar
from obscli.model.trouble import Problems, nearest, shown


NOISE_KEYS: Final = ("Q", "R", "P0", "P0_std", "step")
INTERVAL_KEYS: Final = ("start", "stop", "samples")
MOST_SAMPLES: Final = 10_000_000


@dataclass(frozen=True, slots=True, eq=False)
class Targets:
    """The names that noise may be given for."""

    states: Collection[str]
    disturbances: Collection[str]
    outputs: Collection[str]
    sizes: tuple[int, int, int]  # how many states, disturbances, outputs, as scalars


def kept_noise(
    node: Node | None, path: str, targets: Targets, scope: Scope, problems: Problems
) -> Plain | None:
    """Return ``noise`` checked: keys, names and expressions."""
    if node is None or isinstance(node, Broken):
        return None
    given = fields(node, path, NOISE_KEYS, problems)
    if "P0" in given and "P0_std" in given:
        message = "`P0` and `P0_std` are both given; one of the two"
        problems.add(given["P0_std"][0].problem(path, message))
    n, disturbances, m = targets.sizes
    for key, (_, value) in given.items():
        names, size = (targets.outputs, m) if key == "R" else (targets.states, n)
        if key == "Q" and targets.disturbances:
            names, size = targets.disturbances, disturbances
        _check_values(value, f"{path}.{key}", names, 1 if key == "step" else size, scope, problems)
    return plain(node)


def kept_interval(node: Node | None, path: str, scope: Scope, problems: Problems) -> Interval | None:
    """Return ``interval`` evaluated in the names of its stage."""
    if node is None or isinstance(node, Broken):
        return None
    given = fields(node, path, INTERVAL_KEYS, problems)
    ends: dict[str, Expression | None] = {}
    for key in ("start", "stop"):
        if key in given and not _is_missing(given[key][1], f"{path}.{key}", problems):
            below = f"{path}.{key}"
            ends[key] = constant(formula(given[key][1], below, problems), scope, problems)
    samples = given.get("samples")
    count = whole_of(samples[1], f"{path}.samples", problems, most=MOST_SAMPLES) if samples else None
    return Interval(node.place, ends.get("start"), ends.get("stop"), count)


def kept_require(node: Node | None, names: Collection[str], scope: Scope, problems: Problems) -> Plain | None:
    """Return ``require`` checked: states or quantities with the accuracy asked for."""
    if node is None or isinstance(node, Broken):
        return None
    _check_mapping(node, "require", names, scope, problems)
    return plain(node)


def _check_values(
    node: Node, path: str, names: Collection[str], size: int, scope: Scope, problems: Problems
) -> None:
    """Check a scalar for all, a list of diagonal entries, a square matrix, or a mapping by name."""
    if isinstance(node, Mapping):
        _check_mapping(node, path, names, scope, problems)
        return
    value = _check_expression(node, path, scope, problems)
    if value is not None and not value.is_scalar and value.shape not in {(size,), (size, size)}:
        wanted = f"a scalar, a list of {size} (the diagonal) or a {size}×{size} matrix is expected here"
        problems.add(node.problem(path, f"{wanted}, not {named(value.shape)}"))


def _check_mapping(node: Node, path: str, names: Collection[str], scope: Scope, problems: Problems) -> None:
    for name, (key, value) in fields(node, path, None, problems).items():
        if name not in names:
            message = f"'{shown(name)}' is none of the names expected here{nearest(name, names)}"
            problems.add(key.problem(path, message))
        _check_expression(value, f"{path}.{name}", scope, problems)


def _check_expression(node: Node, path: str, scope: Scope, problems: Problems) -> Tensor | None:
    """Evaluate for the problems' sake; the later command evaluates with its own numbers."""
    if _is_missing(node, path, problems):
        return None
    return evaluate(formula(node, path, problems), scope, problems)


def _is_missing(node: Node, path: str, problems: Problems) -> bool:
    """Whether nothing stands where an expression should (which is reported)."""
    missing = isinstance(node, Scalar) and node.is_null
    if missing:
        problems.add(node.problem(path, "an expression is missing here"))
    return missing
