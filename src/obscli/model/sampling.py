"""``outputs``: unit, time between samples, and intervals with samples: between them are outages.

A value may stand under the name of an output, or of the vector it is a component of; what is said of the
component goes before what is said of the vector.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Final, TypeAlias

from obscli.model.constant import unmoving
from obscli.model.constants import multiple_of_pi
from obscli.model.draft import Draft, OutputDraft, SpanDraft
from obscli.model.environment import Environment
from obscli.model.expression import ZERO, Expression, Number, TimeDerivative, add, negate, substitute
from obscli.model.formula import Formula, formula
from obscli.model.keys import fields, items_of, name_of, text_of
from obscli.model.system import Output
from obscli.model.tree import Broken, Node, Scalar
from obscli.model.tree import Sequence as SequenceNode
from obscli.model.trouble import Problems


OUTPUT_KEYS: Final = ("unit", "every", "during", "description")
_EXAMPLE: Final = "[[0, 60], [90, 200]]"

#: From one instant to another, both included.
Span: TypeAlias = tuple[Expression, Expression]

_Sampling: TypeAlias = tuple[Expression | None, tuple[Span, ...] | None]


def read_outputs(node: Node | None, path: str, problems: Problems) -> dict[str, OutputDraft]:
    """Read what a file or a stage says of outputs."""
    result = {}
    for name, (key, value) in fields(node, path, None, problems).items():
        below = f"{path}.{name}"
        given = fields(value, below, OUTPUT_KEYS, problems)
        text_of(given.get("description"), f"{below}.description", problems)
        if name_of(key, path, problems) is not None:
            result[name] = OutputDraft(
                key,
                text_of(given.get("unit"), f"{below}.unit", problems),
                _every(given["every"][1], f"{below}.every", problems) if "every" in given else None,
                _during(given["during"][1], f"{below}.during", problems) if "during" in given else None,
            )
    return result


def _every(node: Node, path: str, problems: Problems) -> Formula | None:
    if isinstance(node, Scalar) and node.is_null:
        problems.add(node.problem(path, "an expression is missing here"))
        return None
    return formula(node, path, problems)


def _during(node: Node, path: str, problems: Problems) -> tuple[SpanDraft, ...] | None:
    """Read a list of intervals."""
    hint = f"a list of [start, stop]: {_EXAMPLE}"
    if isinstance(node, Scalar):
        what = "intervals are missing here" if node.is_null else "a list of intervals is expected here"
        problems.add(node.problem(path, what, hint))
        return None
    items = items_of(node, path, problems)
    if items and all(isinstance(item, Scalar) for item in items):
        problems.add(node.problem(path, "a list of intervals is expected here, not of instants", hint))
        return None
    if isinstance(node, SequenceNode) and not items:
        hint = "leave the output out (--outputs), or delete the key"
        problems.add(node.problem(path, "no interval is given: the output would never be sampled", hint))
    spans = [_span(item, f"{path}[{k}]", problems) for k, item in enumerate(items, start=1)]
    return tuple(span for span in spans if span is not None)


def _span(node: Node, path: str, problems: Problems) -> SpanDraft | None:
    if isinstance(node, SequenceNode) and len(node.items) == 2:
        start, stop = (formula(item, path, problems) for item in node.items)
        return SpanDraft(node, path, start, stop)
    if not isinstance(node, Broken):
        hint = f"a list of [start, stop]: {_EXAMPLE}"
        problems.add(node.problem(path, "an interval is expected here: [start, stop]", hint))
    return None


def sampled(
    outputs: Sequence[Output], draft: Draft, known: Environment, problems: Problems
) -> tuple[Output, ...]:
    """Return the outputs with their sampling, evaluated in the names of a stage."""
    there = _There(known, draft.time or "t", problems)
    said = {name: (there.step(one.every), there.intervals(one.during)) for name, one in draft.outputs.items()}
    return tuple(_sampled(one, said) for one in outputs)


def _sampled(output: Output, said: Mapping[str, _Sampling]) -> Output:
    """Return an output with what is said of it, or else of its vector."""
    own, whole = (said.get(name, (None, None)) for name in (output.name, output.vector))
    return replace(output, every=own[0] or whole[0], during=own[1] or whole[1])


class _There:
    """Evaluates sampling in the names of a stage, and judges it at the stage's nominal values."""

    def __init__(self, known: Environment, time: str, problems: Problems) -> None:
        self._scope = known.scope
        self._nominal = {one.name: one.nominal for one in known.parameters if one.nominal is not None}
        self._derive = TimeDerivative(time, {}, frozenset())
        self._problems = problems

    def step(self, every: Formula | None) -> Expression | None:
        """Return the time between samples."""
        value = None if every is None else unmoving(every, self._scope, self._problems)
        if every is not None and value is not None and self._is_before(value, ZERO, equal=True):
            self._problems.add(every.problem("a positive time is expected here"))
        return value

    def intervals(self, spans: Sequence[SpanDraft] | None) -> tuple[Span, ...] | None:
        """Return the intervals with samples."""
        if spans is None:
            return None
        found: list[Span] = []
        for span in spans:
            start, stop = (unmoving(end, self._scope, self._problems) for end in (span.start, span.stop))
            if start is None or stop is None:
                continue
            if self._is_before(stop, start, equal=True):
                self._problems.add(span.node.problem(span.path, "the interval does not stop after its start"))
            elif found and self._is_before(start, found[-1][1]):
                message = "the interval begins before the one in front of it stops"
                hint = "intervals are given in order and do not overlap"
                self._problems.add(span.node.problem(span.path, message, hint))
            found.append((start, stop))
        return tuple(found)

    def _is_before(self, first: Expression, second: Expression, *, equal: bool = False) -> bool:
        """Whether an instant is known to be before another, or ``equal``."""
        apart = self._size(add(second, negate(first)))
        return apart is not None and (apart > 0 or (equal and apart == 0))

    def _size(self, value: Expression) -> Fraction | None:
        """Return a number of the sign that the value has, None where it takes more than arithmetic."""
        there = substitute(value, self._nominal, self._derive)
        return there.value if isinstance(there, Number) else multiple_of_pi(there)
