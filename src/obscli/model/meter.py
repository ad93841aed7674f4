"""How large a model becomes when its names are expanded: work, nodes, depth and degree, each with a limit."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from obscli.model.expression import Expression, Number, Pi, Power, Product, Sum, children
from obscli.model.form import Form, Impossible
from obscli.model.trouble import Silence


MOST_WORK: Final = 100_000
DEEPEST: Final = 200
HIGHEST: Final = 10_000


class Meter:
    """Counts operations, distinct nodes, depth and degree over one reading.

    Parameters
    ----------
    most : operations allowed
    """

    def __init__(self, most: int = MOST_WORK) -> None:
        self._most = most
        self._work = 0
        self._measured: dict[int, tuple[Expression, int, int]] = {}

    @property
    def is_exhausted(self) -> bool:
        """Whether the limit is reached; nothing more is evaluated then."""
        return self._work > self._most

    def charge(self, amount: int) -> None:
        """Add to the work done."""
        if self.is_exhausted:
            raise Silence
        self._work += amount
        if self.is_exhausted:
            raise Impossible(
                f"the model takes over {self._most:,} operations to expand",
                "a model takes a few thousand; look for expressions that grow at every step",
            )

    def weigh(self, forms: Iterable[Form]) -> None:
        """Measure the expressions in the forms; shared ones count once."""
        for form in forms:
            for node in (form.constant, *form.linear.values()):
                depth, degree = self._measure(node)
                if depth > DEEPEST:
                    raise Impossible(
                        f"names expand to an expression over {DEEPEST} deep", "shorten the chain of `let`"
                    )
                if degree > HIGHEST:
                    raise Impossible(
                        f"multiplied out, this expression has powers beyond {HIGHEST}",
                        "look for a chain of `let` that squares at every step",
                    )

    def _measure(self, root: Expression) -> tuple[int, int]:
        """Return the depth, and a bound on the degree when everything is multiplied out."""
        stack = [root]
        while stack:
            node = stack[-1]
            if id(node) in self._measured:
                stack.pop()
                continue
            parts = children(node)
            waiting = [part for part in parts if id(part) not in self._measured]
            if waiting:
                stack.extend(waiting)
                continue
            stack.pop()
            known = [self._measured[id(part)] for part in parts]
            depth = 1 + max((one[1] for one in known), default=0)
            self._measured[id(node)] = (node, depth, _degree(node, [one[2] for one in known]))
            self.charge(1)
        _, depth, degree = self._measured[id(root)]
        return depth, degree


def _degree(node: Expression, parts: list[int]) -> int:
    match node:
        case Number() | Pi():
            return 0
        case Product():
            return sum(parts)
        case Power(exponent=exponent):
            return parts[0] * -(-abs(exponent.numerator) // exponent.denominator)
        case Sum():
            return max(parts)
    return 1
