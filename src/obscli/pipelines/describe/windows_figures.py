"""Figures of local observability against time: equivalent singular values, posterior ratios.

By stage, and of several stages side by side: a panel for every quantity and state, a curve for every stage.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from obscli.core.figure import Curve, Figure, Panel
from obscli.numeric.program import Array
from obscli.numeric.window_measures import WindowValues
from obscli.pipelines.windows_result import Windows, WindowsResult


#: Points of a curve, and panels of a figure.
POINTS: Final = 2000
PANELS: Final = 8


@dataclass(frozen=True, slots=True, eq=False)
class _Kind:
    """What is drawn: the key of a measure, a title and the label of its axis."""

    key: str
    title: str
    label: str

    def of(self, values: WindowValues) -> Array:
        """Return the values, (windows, forms)."""
        return values.equivalent if self is _INDEX else values.posterior


_INDEX: Final = _Kind("equivalent-singular-value", "equivalent singular values", "σ̃")
_RATIO: Final = _Kind("posterior-ratio", "what a window leaves of the prior's deviation", "p")


def windows_figures(results: Iterable[WindowsResult]) -> Iterator[Figure]:
    """Yield the figures of every stage that has windows, then of several stages of a model together."""
    drawn = [(result, result.found) for result in results if isinstance(result.found, Windows)]
    for result, found in drawn:
        for kind in _kinds([found]):
            panels = [_panel(found, kind, group) for group in _groups(result, found)[:PANELS]]
            name, title = f"{result.title}-window-{kind.key}", f"{result.title}: {kind.title}"
            yield Figure(name, title, result.system.time, tuple(panels))
    if len(drawn) > 1:
        yield from _together(drawn)


def _together(drawn: Sequence[tuple[WindowsResult, Windows]]) -> Iterator[Figure]:
    """Yield quantities, and the states of each vector, with a curve for every stage."""
    first, found = drawn[0]
    for kind in _kinds([one for _, one in drawn]):
        for group in _groups(first, found):
            names = [found.names[k] for k in group]
            panels = [_compared(drawn, kind, name) for name in names[:PANELS]]
            label = "quantities" if group[0] >= first.system.n else _vector(first, group[0])
            name = f"{first.model.name}-window-{kind.key}-{label}"
            title = f"{first.model.name}: {kind.title} in each stage"
            yield Figure(name, title, first.system.time, tuple(panels))


def _compared(drawn: Sequence[tuple[WindowsResult, Windows]], kind: _Kind, name: str) -> Panel:
    """Return the panel of one quantity or state; stages that do not have it have no curve."""
    curves = [
        _curve(result.system.stage or result.model.name, found, kind, found.names.index(name))
        for result, found in drawn
        if name in found.names
    ]
    return Panel(name, kind.label, tuple(curves))


def _kinds(found: Sequence[Windows]) -> list[_Kind]:
    """Return what can be drawn of all: without a prior or noise there is no ratio."""
    ratio = all(np.isfinite(one.values.posterior).all() for one in found)
    return [_INDEX, *([_RATIO] if ratio else [])]


def _vector(result: WindowsResult, k: int) -> str:
    return result.system.states[k].vector or "states"


def _groups(result: WindowsResult, found: Windows) -> list[list[int]]:
    """Return quantities together, then the states of each vector, of those that are shown."""
    system = result.system
    quantities = [k for k in found.shown if k >= system.n]
    by_vector: dict[str, list[int]] = {}
    for k in (one for one in found.shown if one < system.n):
        by_vector.setdefault(_vector(result, k), []).append(k)
    return [quantities] * bool(quantities) + list(by_vector.values())


def _panel(found: Windows, kind: _Kind, group: Sequence[int]) -> Panel:
    curves = tuple(_curve(found.names[k], found, kind, k) for k in group)
    return Panel(", ".join(found.names[k] for k in group), kind.label, curves)


def _curve(label: str, found: Windows, kind: _Kind, k: int) -> Curve:
    """Return the curve of one linear form, thinned."""
    thin = slice(None, None, max(1, -(-len(found.values.t) // POINTS)))
    t, values = found.values.t[thin], kind.of(found.values)[thin, k]
    return Curve(label, tuple(t.tolist()), tuple(values.tolist()))
