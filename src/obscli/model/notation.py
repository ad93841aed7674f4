"""How expressions and linear combinations are written: as in the file, and in LaTeX."""

from obscli.model.latex import latex_name
from obscli.model.typeset import covector_latex, to_latex
from obscli.model.written import covector_text, decimal_text, to_text


__all__ = ["covector_latex", "covector_text", "decimal_text", "latex_name", "to_latex", "to_text"]
