"""Linear forms in the states that are followed: the states themselves, quantities, combinations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from obscli.model.expression import ONE
from obscli.model.system import Covector, System
from obscli.numeric.numeric_system import NumericSystem
from obscli.numeric.program import Array
from obscli.numeric.simulation_finding import Followed


@dataclass(frozen=True, slots=True, eq=False)
class Forms:
    """``names``, ``kinds``, ``covectors`` of r linear forms, (r,) each; coefficients may vary with time."""

    names: tuple[str, ...]
    kinds: tuple[Followed, ...]
    covectors: tuple[Covector, ...]

    def at(self, numeric: NumericSystem, t: Array) -> Array:
        """Return the forms at k instants, shape (k, r, n); not numbers where one does not exist."""
        found = numeric.covectors(self.covectors, t)[0]
        found[~np.isfinite(found).all(axis=2)] = np.nan
        return found


def forms_of(system: System, combinations: Sequence[tuple[str, Covector]] = ()) -> Forms:
    """Return the states of a system, its quantities, then combinations with their names."""
    states: list[tuple[str, Followed, Covector]] = [(s, "state", {s: ONE}) for s in system.state_names]
    quantities: list[tuple[str, Followed, Covector]] = [
        (one.name, "quantity", one.coefficients) for one in system.quantities
    ]
    others: list[tuple[str, Followed, Covector]] = [
        (name, "combination", covector) for name, covector in combinations
    ]
    names, kinds, covectors = zip(*states, *quantities, *others, strict=True)
    return Forms(names, kinds, covectors)
