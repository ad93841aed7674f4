"""Figures of local observability against time: equivalent singular values, posterior ratios."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Final

import numpy as np

from obscli.core.figure import Curve, Figure, Panel
from obscli.numeric.program import Array
from obscli.pipelines.windows_result import Windows, WindowsResult


#: Points of a curve, and panels of a figure.
POINTS: Final = 2000
PANELS: Final = 8


def windows_figures(results: Iterable[WindowsResult]) -> Iterator[Figure]:
    """Yield the figures of every stage that has windows."""
    for result in results:
        if isinstance(result.found, Windows):
            yield from _figures(result, result.found)


def _figures(result: WindowsResult, found: Windows) -> Iterator[Figure]:
    values = found.values
    kinds = [("equivalent-singular-value", "equivalent singular values", "σ̃", values.equivalent)]
    if np.isfinite(values.posterior).all():
        kinds.append(
            ("posterior-ratio", "what a window leaves of the prior's deviation", "p", values.posterior)
        )
    groups = _groups(result, found)[:PANELS]
    for name, title, label, columns in kinds:
        yield Figure(
            f"{result.title}-window-{name}",
            f"{result.title}: {title}",
            result.system.time,
            tuple(_panel(found, columns, group, label) for group in groups),
        )


def _groups(result: WindowsResult, found: Windows) -> list[list[int]]:
    """Return quantities together, then the states of each vector."""
    system = result.system
    quantities = list(range(system.n, len(found.names)))
    by_vector: dict[str, list[int]] = {}
    for k, state in enumerate(system.states):
        by_vector.setdefault(state.vector or "states", []).append(k)
    return [quantities] * bool(quantities) + list(by_vector.values())


def _panel(found: Windows, columns: Array, group: Sequence[int], label: str) -> Panel:
    thin = slice(None, None, max(1, -(-len(found.values.t) // POINTS)))
    t = tuple(found.values.t[thin].tolist())
    curves = tuple(Curve(found.names[k], t, tuple(columns[thin, k].tolist())) for k in group)
    return Panel(", ".join(found.names[k] for k in group), label, curves)
