"""Figures of a simulation: deviations against time, consistency of random runs, a mismatched filter."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Final

from obscli.core.figure import Curve, Emphasis, Figure, Panel
from obscli.numeric.finding import NotComputed
from obscli.pipelines.simulate_result import FollowedForm, Mismatch, SimulateResult, Simulation


if TYPE_CHECKING:
    from obscli.numeric.program import Array
    from obscli.numeric.simulation_finding import Consistency, MonteCarlo

#: Forms in one panel, and panels in one figure.
CURVES: Final = 2
PANELS: Final = 4
STYLES: Final[tuple[Emphasis, ...]] = ("main", "one of many")


def simulate_figures(results: Iterable[SimulateResult]) -> Iterator[Figure]:
    """Yield the figures of every stage that was simulated."""
    for result in results:
        found = result.found
        if isinstance(found, NotComputed):
            continue
        time = result.system.time
        yield from _deviations(result.title, time, found)
        if found.mismatch is not None:
            yield from _mismatch(result.title, time, found.mismatch)
        if found.monte_carlo is not None:
            yield _consistency(result.title, time, found.monte_carlo)


def _deviations(title: str, time: str, found: Simulation) -> Iterator[Figure]:
    """Yield σ against time with the open loop and what is required; forms of one vector stand together."""
    kinds = {
        "deviations": [k for k, one in enumerate(found.forms) if one.kind != "combination"],
        "combinations": [k for k, one in enumerate(found.forms) if one.kind == "combination"],
    }
    required = {one.name: one.limit for one in found.demands}
    for name, indices in kinds.items():
        panels = [_panel(found, part, required) for part in _parts(found.forms, indices)]
        yield from _figures(f"{title}-{name}", f"{title}: standard deviations", time, panels)


def _figures(name: str, title: str, time: str, panels: Sequence[Panel]) -> Iterator[Figure]:
    for k in range(0, len(panels), PANELS):
        part = f"-{k // PANELS + 1}" if len(panels) > PANELS else ""
        yield Figure(name + part, title, time, tuple(panels[k : k + PANELS]))


def _parts(forms: Sequence[FollowedForm], indices: Sequence[int]) -> Iterator[list[int]]:
    """Yield indices of forms of one unit, as many as one panel takes; combinations one a panel."""
    groups: dict[tuple[str, str], list[int]] = {}
    for k in indices:
        form = forms[k]
        apart = form.name if form.kind != "state" or not form.unit else ""
        groups.setdefault((form.unit, apart), []).append(k)
    for group in groups.values():
        for k in range(0, len(group), CURVES):
            yield group[k : k + CURVES]


def _panel(found: Simulation, indices: Sequence[int], required: dict[str, float]) -> Panel:
    history = found.history
    curves: list[Curve] = []
    for k, style in zip(indices, STYLES, strict=False):
        name = history.names[k]
        curves += _curve(name, history.t, history.deviations[:, k], style)
        curves += _curve(f"{name}, nothing measured", history.t, history.open_loop[:, k], "reference")
        if name in required:
            ends = (float(history.t[0]), float(history.t[-1]))
            curves.append(Curve(f"{name}, required", ends, (required[name], required[name]), "limit"))
    return Panel(
        _title(found.forms, indices),
        _label("σ", found.forms[indices[0]].unit),
        tuple(curves),
        logarithmic=True,
    )


def _title(forms: Sequence[FollowedForm], indices: Sequence[int]) -> str:
    return ", ".join(forms[k].name for k in indices)


def _label(what: str, unit: str) -> str:
    return f"{what} [{unit}]" if unit else what


def _curve(label: str, t: Array, values: Array, style: Emphasis) -> Iterator[Curve]:
    """Yield the curve where it can be drawn on a logarithmic scale."""
    pairs = [(float(x), float(y)) for x, y in zip(t, values, strict=True) if math.isfinite(y) and y > 0]
    if pairs:
        x, y = zip(*pairs, strict=True)
        yield Curve(label, x, y, style)


def _mismatch(title: str, time: str, one: Mismatch) -> Iterator[Figure]:
    """Yield for every form what the filter claims and what is true."""
    found = one.history
    units = {state.name: state.unit for state in one.system.states}
    panels = [
        Panel(
            name,
            _label("σ", units.get(name, "")),
            (
                *_curve("true", found.t, found.true[:, k], "main"),
                *_curve("as the filter claims", found.t, found.claimed[:, k], "reference"),
            ),
            logarithmic=True,
        )
        for k, name in enumerate(found.names)
    ]
    yield from _figures(
        f"{title}-mismatch", f"{title}: the filter designed on {one.model.name}", time, panels
    )


def _consistency(title: str, time: str, found: MonteCarlo) -> Figure:
    """Return NEES and NIS against time with their bands."""
    parts = [("NEES", found.nees), *([("NIS", found.nis)] if found.nis is not None else [])]
    panels = tuple(_band(name, one, found.confidence) for name, one in parts)
    return Figure(f"{title}-consistency", f"{title}: {found.runs} random runs", time, panels)


def _band(name: str, one: Consistency, confidence: float) -> Panel:
    t = tuple(one.t.tolist())
    curves = (
        Curve("average over the runs", t, tuple(one.average.tolist())),
        Curve(f"{100 * confidence:g} % band", t, tuple(one.lower.tolist()), "limit"),
        Curve("", t, tuple(one.upper.tolist()), "limit"),
    )
    return Panel(
        f"{name}: {100 * one.inside:.0f} % of the instants inside", f"{name} / degrees of freedom", curves
    )
