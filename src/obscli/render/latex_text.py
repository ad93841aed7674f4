r"""Text and formulas made safe for LaTeX: no character of a file can start a command or end a group."""

from __future__ import annotations

from typing import Final

from obscli.core.visible import visible


SPECIAL: Final = {
    "\\": r"\textbackslash{}",
    "{": r"\{",
    "}": r"\}",
    "$": r"\$",
    "&": r"\&",
    "#": r"\#",
    "_": r"\_",
    "%": r"\%",
    "^": r"\textasciicircum{}",
    "~": r"\textasciitilde{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    '"': r"\textquotedbl{}",
    "[": "{[}",
    "]": "{]}",
    "*": "{*}",
}

#: Signs that obscli itself writes, and Greek, which T1 fonts do not have.
SIGNS: Final = {
    "●": r"$\bullet$",
    "◐": r"$\circledcirc$",
    "·": r"$\cdot$",
    "×": r"$\times$",
    "≥": r"$\geq$",
    "≤": r"$\leq$",
    "→": r"$\to$",
    "−": r"$-$",
    "±": r"$\pm$",
    "∈": r"$\in$",
    "≠": r"$\neq$",
    "–": "--",
    "′": r"$'$",
    "✓": r"$\checkmark$",
    "✗": r"$\times$",
}
GREEK: Final = {
    "α": "alpha", "β": "beta", "γ": "gamma", "δ": "delta", "ε": "varepsilon", "ζ": "zeta", "η": "eta",
    "θ": "theta", "ι": "iota", "κ": "kappa", "λ": "lambda", "μ": "mu", "ν": "nu", "ξ": "xi", "π": "pi",
    "ρ": "rho", "σ": "sigma", "ς": "varsigma", "τ": "tau", "υ": "upsilon", "φ": "varphi", "ϕ": "phi",
    "χ": "chi", "ψ": "psi", "ω": "omega", "Γ": "Gamma", "Δ": "Delta", "Θ": "Theta", "Λ": "Lambda", "Ξ": "Xi",
    "Π": "Pi", "Σ": "Sigma", "Φ": "Phi", "Ψ": "Psi", "Ω": "Omega",
}  # fmt: skip
IN_TEXT: Final = SPECIAL | SIGNS | {letter: rf"$\{name}$" for letter, name in GREEK.items()}

#: In a formula backslash, braces, ^ and _ are the writer's own; these would end it or comment it out.
IN_MATH: Final = {"$": r"\$", "%": r"\%", "#": r"\#", "&": r"\&", "~": r"\sim "} | {
    letter: rf"\{name} " for letter, name in GREEK.items()
}


def in_text(text: str) -> str:
    """Return raw text as LaTeX text that shows it."""
    return "".join(IN_TEXT.get(character, character) for character in visible(text))


def in_math(latex: str) -> str:
    """Return a LaTeX formula without control characters, and with those defused that could leave it."""
    return "".join(
        IN_MATH.get(character, character) for character in latex if visible(character) == character
    )
