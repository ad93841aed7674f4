"""How large a model becomes when its names are expanded: work, nodes and depth, each with a limit."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from obscli.model.expression import Expression, children
from obscli.model.form import Form, Impossible
from obscli.model.trouble import Silence


MOST_WORK: Final = 100_000
DEEPEST: Final = 200


class Meter:
    """Counts operations, distinct nodes and depth over one reading."""

    def __init__(self) -> None:
        self._work = 0
        self._depths: dict[int, tuple[Expression, int]] = {}

    @property
    def is_exhausted(self) -> bool:
        """Whether the limit is reached; nothing more is evaluated then."""
        return self._work > MOST_WORK

    def charge(self, amount: int) -> None:
        """Add to the work done."""
        if self.is_exhausted:
            raise Silence
        self._work += amount
        if self.is_exhausted:
            raise Impossible(
                f"the model takes over {MOST_WORK:,} operations to expand",
                "a model takes a few thousand; look for expressions that grow at every step",
            )

    def weigh(self, forms: Iterable[Form]) -> None:
        """Measure the expressions in the forms; shared ones count once."""
        for form in forms:
            for node in (form.constant, *form.linear.values()):
                if self._depth(node) > DEEPEST:
                    raise Impossible(
                        f"names expand to an expression over {DEEPEST} deep", "shorten the chain of `let`"
                    )

    def _depth(self, root: Expression) -> int:
        stack = [root]
        while stack:
            node = stack[-1]
            if id(node) in self._depths:
                stack.pop()
                continue
            parts = children(node)
            waiting = [part for part in parts if id(part) not in self._depths]
            if waiting:
                stack.extend(waiting)
                continue
            stack.pop()
            depth = 1 + max((self._depths[id(part)][1] for part in parts), default=0)
            self._depths[id(node)] = (node, depth)
            self.charge(1)
        return self._depths[id(root)][1]
