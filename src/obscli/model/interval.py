"""``interval``: its ends evaluated in the names of a stage."""

from __future__ import annotations

from typing import Final

from obscli.model.constant import constant
from obscli.model.expression import Expression
from obscli.model.formula import formula
from obscli.model.keys import fields, whole_of
from obscli.model.scope import Scope
from obscli.model.system import Interval
from obscli.model.tree import Broken, Node, Scalar
from obscli.model.trouble import Problems


INTERVAL_KEYS: Final = ("start", "stop", "samples")
MOST_SAMPLES: Final = 10_000_000


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


def _is_missing(node: Node, path: str, problems: Problems) -> bool:
    """Whether nothing stands where an expression should (which is reported)."""
    missing = isinstance(node, Scalar) and node.is_null
    if missing:
        problems.add(node.problem(path, "an expression is missing here"))
    return missing
