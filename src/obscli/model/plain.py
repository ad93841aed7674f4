"""Parts of the file as one line of text."""

from __future__ import annotations

from obscli.model.tree import Broken, Mapping, Node, Scalar, Sequence


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
