"""A value of the file, parsed but not yet evaluated: one text, or YAML lists of texts."""

from __future__ import annotations

from dataclasses import dataclass

from obscli.core.place import Place, Problem
from obscli.model.syntax import Step, parse
from obscli.model.tokens import Mistake
from obscli.model.tree import Broken, Mapping, Node, Scalar, Sequence
from obscli.model.trouble import Problems, Trouble


@dataclass(frozen=True, slots=True, eq=False)
class Located:
    """A step of the postfix form and the node it comes from."""

    step: Step
    node: Scalar | Sequence


@dataclass(frozen=True, slots=True, eq=False)
class Formula:
    """An expression in postfix form with its key path; not ``sound`` where parts are already reported."""

    path: str
    node: Node
    steps: tuple[Located, ...]
    sound: bool = True

    @property
    def place(self) -> Place:
        """Where the expression begins."""
        return self.node.place

    def problem(self, message: str, hint: str = "", at: Located | None = None) -> Problem:
        """Return a problem of the expression, or of one word of it."""
        node = at.node if at else self.node
        if at is None or not isinstance(node, Scalar):
            return node.problem(self.path, message, hint)
        return node.problem(self.path, message, hint, offset=at.step.offset, width=at.step.width)

    def trouble(self, message: str, hint: str = "", at: Located | None = None) -> Trouble:
        """Return the problem as an exception."""
        return Trouble(self.problem(message, hint, at))

    @property
    def names(self) -> frozenset[str]:
        """The names used as values."""
        return frozenset(s.step.text for s in self.steps if s.step.operation == "name")

    @property
    def text(self) -> str:
        """The expression as written, where it is one text."""
        return self.node.text.strip() if isinstance(self.node, Scalar) else ""


def times_matrix(one: Formula, matrix: Formula) -> Formula:
    """Return ``one @ matrix``, in the place of the first."""
    at = one.steps[-1].node if one.steps else matrix.steps[-1].node
    steps = (*one.steps, *matrix.steps, Located(Step("@", 0, 1, 2, "@"), at))
    return Formula(one.path, one.node, steps, one.sound and matrix.sound)


def formula(node: Node, path: str, problems: Problems) -> Formula:
    """Parse a node, reporting what is wrong in each of its texts."""
    steps: list[Located] = []
    sound = _collect(node, path, problems, steps)
    return Formula(path, node, tuple(steps), sound)


def _collect(node: Node, path: str, problems: Problems, steps: list[Located]) -> bool:
    match node:
        case Scalar():
            return _collect_text(node, path, problems, steps)
        case Sequence():
            sound = [
                _collect(item, f"{path}[{k}]", problems, steps) for k, item in enumerate(node.items, start=1)
            ]
            steps.append(Located(Step("list", 0, 1, len(node.items), "["), node))
            return all(sound)
        case Mapping():
            problems.add(node.problem(path, "an expression or a list is expected here, not a mapping"))
        case Broken():
            pass
    return False


def _collect_text(node: Scalar, path: str, problems: Problems, steps: list[Located]) -> bool:
    try:
        steps.extend(Located(step, node) for step in parse(node.text))
    except Mistake as mistake:
        problem = node.problem(
            path, mistake.message, mistake.hint, offset=mistake.offset, width=mistake.width
        )
        problems.add(problem)
        return False
    return True
