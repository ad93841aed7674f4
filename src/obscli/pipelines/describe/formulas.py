"""Combinations and directions of a system as formulas of the document."""

from __future__ import annotations

from obscli.core.document import Cell, Math
from obscli.model.expression import is_one
from obscli.model.notation import covector_latex, covector_text, latex_name, to_latex, to_text
from obscli.model.system import Covector, System
from obscli.pipelines.describe.words import names
from obscli.pipelines.latex_names import latex_names


def combination(covector: Covector, system: System) -> Math:
    """Return s = Σ ξ_i x_i as a formula."""
    states = system.state_names
    return Math(covector_text(covector, states), covector_latex(covector, states, latex_names(system)))


def combinations(covectors: tuple[Covector, ...], system: System) -> Cell:
    """Return combinations as the lines of a cell, those that are a single state together in one line."""
    single = tuple(state for covector in covectors for state in covector if _is_state(covector))
    proper = tuple((combination(covector, system),) for covector in covectors if not _is_state(covector))
    return (*proper, names(single)) if single else proper


def _is_state(covector: Covector) -> bool:
    return len(covector) == 1 and all(is_one(coefficient) for coefficient in covector.values())


def direction(components: Covector, system: System) -> Math:
    """Return a vector of states by its non-zero components, as ``claims: directions`` writes it."""
    present = [(state, components[state.name]) for state in system.states if state.name in components]
    text = ", ".join(f"{state.name}: {to_text(value)}" for state, value in present)
    symbols = latex_names(system)
    latex = r",\; ".join(
        rf"\delta {symbols.get(state.name) or latex_name(state.name)} = {to_latex(value, symbols)}"
        for state, value in present
    )
    return Math(text, latex)
