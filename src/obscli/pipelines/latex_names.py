"""How the file wants its states written in LaTeX."""

from __future__ import annotations

from obscli.model.system import System


def latex_names(system: System) -> dict[str, str]:
    """Return the LaTeX of each state that the file gives one; others are written by their names."""
    return {state.name: state.latex for state in system.states if state.latex}
