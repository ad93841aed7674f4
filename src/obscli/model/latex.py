"""Names and expressions in LaTeX; nothing in a name can break out of its formula."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final

from obscli.model.tree import Node
from obscli.model.trouble import Problems


_FORBIDDEN: Final = re.compile(
    r"[$%#&~^]{2}|[$%#&~<>]|\\(?![A-Za-z{},;:!| ])"
    r"|\\(?:input|include|write|read|open|close|def|edef|gdef|xdef|let|catcode|csname|special|immediate"
    r"|href|url|html\w*|new\w*|renew\w*|provide\w*|usepackage|begin|end|loop|expandafter|every\w*|par)\b"
)
_GREEK: Final = [
    "alpha",
    "beta",
    "gamma",
    "delta",
    "epsilon",
    "zeta",
    "eta",
    "theta",
    "iota",
    "kappa",
    "lambda",
    "mu",
    "nu",
    "xi",
    "pi",
    "rho",
    "sigma",
    "tau",
    "upsilon",
    "phi",
    "chi",
    "psi",
    "omega",
]
_CAPITALS: Final = (
    "Gamma",
    "Delta",
    "Theta",
    "Lambda",
    "Xi",
    "Pi",
    "Sigma",
    "Upsilon",
    "Phi",
    "Psi",
    "Omega",
)
_LETTERS: Final[Mapping[str, str]] = {
    **dict(zip("αβγδεζηθικλμνξπρστυφχψω", _GREEK, strict=True)),
    **dict(zip("ΓΔΘΛΞΠΣΥΦΨΩ", _CAPITALS, strict=True)),
}


def checked_latex(text: str, node: Node, path: str, problems: Problems) -> None:
    """Report LaTeX of the user that could break out of its formula."""
    depth = lowest = 0
    for character in text.replace("\\{", "").replace("\\}", ""):
        depth += {"{": 1, "}": -1}.get(character, 0)
        lowest = min(lowest, depth)
    if depth or lowest < 0:
        problems.add(node.problem(path, "the braces do not match"))
    elif _FORBIDDEN.search(text) or len(text) > 80:
        hint = "a symbol as \\psi or \\delta V, in at most 80 characters; no macros, no $, %, #, &"
        problems.add(node.problem(path, "this LaTeX is refused", hint))


def latex_name(name: str) -> str:
    r"""Return a name in LaTeX: ``omega_ie`` is \omega_{ie}, ``M_g11`` is M_{g,11}."""
    runs = [run for part in name.split("_") for run in re.findall(r"\d+|\D+", part)]
    if not runs:
        return "\\_"
    head, *indices = runs
    if name.startswith("_"):
        head, indices = "", runs
    below = ",".join(_run(index, index) for index in indices)
    return (
        _run(head, f"\\mathit{{{head}}}") + (f"_{{{below}}}" if indices else "")
        if head
        else f"{{}}_{{{below}}}"
    )


def _run(text: str, plain: str) -> str:
    """Return letters or digits in LaTeX; ``plain`` is used for words of several ASCII letters."""
    if text in _GREEK or text in _CAPITALS:
        return "o" if text == "omicron" else f"\\{text}"
    if text in _LETTERS:
        return f"\\{_LETTERS[text]}"
    if text.isascii() and text.isalnum():
        return text if len(text) == 1 or text.isdigit() else plain
    return "".join(_letter(character) for character in text)


def _letter(character: str) -> str:
    if character in _LETTERS:
        return f"\\{_LETTERS[character]} "
    if character.isascii():
        return character if character.isalnum() else ""
    return f"\\text{{{character}}}" if character.isalnum() else ""
