"""Parts of the file kept as they stand for later commands: ``noise``, ``interval``, ``experiment``."""

from __future__ import annotations

from obscli.model.system import Plain
from obscli.model.tree import Broken, Mapping, Node, Scalar, Sequence


def plain(node: Node) -> Plain:
    """Return the node without its YAML form."""
    match node:
        case Scalar():
            return Plain(None if node.is_null else node.text, node.place)
        case Sequence():
            return Plain(tuple(plain(item) for item in node.items), node.place)
        case Mapping():
            return Plain({key.text: plain(value) for key, value in node.entries}, node.place)
        case Broken():
            return Plain(None, node.place)


def flow_text(node: Node) -> str:
    """Return the node on one line, in YAML's flow style."""
    match node:
        case Scalar():
            return " ".join(node.text.split())
        case Sequence():
            return "[" + ", ".join(flow_text(item) for item in node.items) + "]"
        case Mapping():
            return "{" + ", ".join(f"{key.text}: {flow_text(value)}" for key, value in node.entries) + "}"
        case Broken():
            return ""
