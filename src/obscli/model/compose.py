"""From the event stream of PyYAML to a tree, refusing tags, merges, cycles and bombs by name."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Final

import yaml

from obscli.core.place import ModelError, Problem
from obscli.model.pieces import first_open, mend
from obscli.model.source import HARMFUL, Source
from obscli.model.tree import Broken, Mapping, Node, Scalar, Sequence
from obscli.model.trouble import Problems, shown


DEEPEST: Final = 100
MOST_NODES: Final = 100_000
_QUOTE: Final = 'write "…" around an expression with commas, brackets or ": ", as in "cross([0, 0, 1], v)"'
_LOADER: Final = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_TOO_DEEP: Final = f"lists and mappings are nested over {DEEPEST} deep"


@dataclass(slots=True)
class _Open:
    """A collection still being read."""

    event: Any
    path: str
    items: list[Node] = field(default_factory=list)
    size: int = 1


class _Composer:
    """Builds the tree with a stack of its own; ``root`` is the result."""

    def __init__(self, source: Source, problems: Problems) -> None:
        self._source = source
        self._problems = problems
        self._stack: list[_Open] = []
        self._anchors: dict[str, tuple[Node, int]] = {}
        self._total = 0
        self.root: Node | None = None

    def take(self, event: Any) -> None:  # noqa: ANN401
        """Add one event to the tree."""
        match event:
            case yaml.DocumentStartEvent() if self.root is not None:
                self._stop(event, "a second document begins here; a model file is one document")
            case yaml.AliasEvent():
                self._alias(event)
            case yaml.ScalarEvent():
                self._check_tag(event)
                self._finish(self._scalar(event), 1, event.anchor)
            case yaml.SequenceStartEvent() | yaml.MappingStartEvent():
                self._check_tag(event)
                self._open(event)
            case yaml.SequenceEndEvent() | yaml.MappingEndEvent():
                done = self._stack.pop()
                self._finish(self._collection(done), done.size, done.event.anchor)

    def _open(self, event: Any) -> None:  # noqa: ANN401
        if len(self._stack) >= DEEPEST:
            self._stop(event, _TOO_DEEP, path="")
        if event.anchor:
            self._anchors.pop(event.anchor, None)
        self._stack.append(_Open(event, self._path()))

    def _path(self) -> str:
        """Return the key path of the node that begins now."""
        if not self._stack:
            return ""
        top = self._stack[-1]
        if isinstance(top.event, yaml.SequenceStartEvent):
            return f"{top.path}[{len(top.items) + 1}]"
        key = top.items[-1] if len(top.items) % 2 else None
        name = key.text if isinstance(key, Scalar) else "?"
        return f"{top.path}.{name}" if top.path else name

    def _scalar(self, event: Any) -> Scalar:  # noqa: ANN401
        start, end = event.start_mark, event.end_mark
        raw = self._source.text[start.index : end.index]
        style = event.style or ""
        scalar = Scalar(self._source, start.line + 1, start.column + 1, event.value, raw, style)
        harmful = HARMFUL.search(event.value) if style == '"' else None
        if harmful:
            message = (
                f"an escape in this text gives the character U+{ord(harmful[0]):04X}, which is not allowed"
            )
            hint = "control characters, escape codes and invisible marks have no place in a model; delete it"
            self._problems.add(scalar.problem(self._path(), message, hint))
            clean = HARMFUL.sub("?", event.value)
            return Scalar(self._source, scalar.line, scalar.column, clean, raw, style)
        return scalar

    def _collection(self, done: _Open) -> Node:
        mark, flow = done.event.start_mark, bool(done.event.flow_style)
        line, column = mark.line + 1, mark.column + 1
        if flow:
            self._mend(done, line, column)
        if isinstance(done.event, yaml.SequenceStartEvent):
            return Sequence(self._source, line, column, tuple(done.items))
        return Mapping(self._source, line, column, tuple(self._entries(done)))

    def _mend(self, done: _Open, line: int, column: int) -> None:
        """Replace the pieces of split expressions, now reported, by broken nodes."""
        pieces = mend(done.items, done.path, self._problems)
        if isinstance(done.event, yaml.MappingStartEvent):
            for at in range(0, len(done.items), 2):
                if pieces.get(at + 1):
                    done.items[at + 1] = Broken(self._source, line, column)
            dropped = {at - at % 2 for at, first in pieces.items() if at % 2 == 0 or not first}
            done.items = [x for at, x in enumerate(done.items) if at - at % 2 not in dropped]
        elif pieces:
            broken = [
                Broken(self._source, line, column) if pieces.get(at) else x for at, x in enumerate(done.items)
            ]
            done.items = [x for at, x in enumerate(broken) if pieces.get(at) is not False]

    def _entries(self, done: _Open) -> Iterator[tuple[Scalar, Node]]:
        seen: dict[str, Scalar] = {}
        for key, value in zip(done.items[::2], done.items[1::2], strict=True):
            if not isinstance(key, Scalar):
                self._problems.add(
                    key.problem(done.path, "a key must be a plain name, not a list or mapping")
                )
            elif key.text == "<<" and not key.style:
                self._problems.add(
                    key.problem(done.path, "merge keys ('<<') are not supported; write it out")
                )
            elif key.text in seen:
                message = f"the key '{shown(key.text)}' is given twice, first in line {seen[key.text].line}"
                self._problems.add(key.problem(done.path, message))
            else:
                seen[key.text] = key
                yield key, value

    def _alias(self, event: Any) -> None:  # noqa: ANN401
        known = self._anchors.get(event.anchor)
        if known is None:
            name = shown(event.anchor)
            message = f"'*{name}' refers to no anchor '&{name}' completed above"
            hint = "quote an expression that begins with '*'"
            self._stop(event, message, hint)
        else:
            self._finish(*known, None)

    def _finish(self, node: Node, size: int, anchor: str | None) -> None:
        self._total += 1
        top = self._stack[-1] if self._stack else None
        if top is not None:
            top.size += size
        if self._total > MOST_NODES or (top is not None and top.size > MOST_NODES):
            message = f"the file holds over {MOST_NODES:,} values (anchors expanded)"
            raise ModelError([node.problem("", message)])
        if anchor:
            self._anchors[anchor] = (node, size)
        if top is None:
            self.root = node
        else:
            top.items.append(node)

    def _check_tag(self, event: Any) -> None:  # noqa: ANN401
        if event.tag is not None and event.tag != "!":
            name = event.tag.replace("tag:yaml.org,2002:", "!!")
            self._stop(event, f"YAML tags such as '{shown(name)}' are refused", "delete the tag")

    def _stop(self, event: Any, message: str, hint: str = "", path: str | None = None) -> None:  # noqa: ANN401
        mark = event.start_mark
        problem = self._source.problem(
            mark.line + 1, mark.column + 1, 1, self._path() if path is None else path, message, hint
        )
        self._problems.add(problem)
        self._problems.raise_any()


def compose(source: Source, problems: Problems) -> Node | None:
    """Return the tree of the text, None where it is empty.

    Raises
    ------
    ModelError
        where the text is no YAML, or YAML that is refused
    """
    composer = _Composer(source, problems)
    try:
        for event in yaml.parse(source.text, Loader=_LOADER):
            composer.take(event)
    except yaml.MarkedYAMLError as error:
        problems.add(_syntax(source, error))
        problems.raise_any()
    except (yaml.YAMLError, UnicodeError, ValueError) as error:
        problems.add(source.problem(1, 1, 1, "", f"this is no YAML: {shown(str(error))}"))
        problems.raise_any()
    return composer.root


def _syntax(source: Source, error: yaml.MarkedYAMLError) -> Problem:
    """Return PyYAML's complaint as a problem, with advice where an unquoted expression is the cause."""
    mark = error.problem_mark or error.context_mark
    line, column = (mark.line + 1, mark.column + 1) if mark else (1, 1)
    text = source.line(line)
    what = shown(f"{error.problem or error.context}")
    if "maximum nesting depth" in what:  # the scanner of PyYAML 6.0.4 reads ahead and gives up by itself
        return source.problem(line, column, 1, "", _TOO_DEEP)
    opening = text[: column - 1].rfind("(")
    if "did not find expected ','" in what and opening >= 0 and first_open(text[opening : column - 1]) == 0:
        message = "quote this expression: YAML reads its brackets and commas as its own"
        return source.problem(line, opening + 1, 1, "", message, _QUOTE)
    if "\t" in text[:column]:
        return source.problem(line, column, 1, "", f"this is no YAML: {what}", "indent with spaces, not tabs")
    start = error.context_mark
    if start and start.line + 1 < line and "flow" in (error.context or ""):
        place = f"line {start.line + 1}, column {start.column + 1}"
        hint = f"the bracket opened in {place}, is not closed before this"
    else:
        hint = _QUOTE if any(c in text for c in "([{*@&%") else ""
    return source.problem(line, column, 1, "", f"this is no YAML: {what}", hint)
