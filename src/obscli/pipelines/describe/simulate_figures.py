"""Figures of a simulation: deviations against time, consistency of random runs, a mismatched filter."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from obscli.core.figure import Curve, Emphasis, Figure, Panel
from obscli.model.system import System
from obscli.numeric.finding import NotComputed
from obscli.pipelines.simulate_result import FollowedForm, Initial, Mismatch, SimulateResult, Simulation


if TYPE_CHECKING:
    from obscli.numeric.program import Array
    from obscli.numeric.simulation_finding import Consistency, MonteCarlo

#: Forms in one panel, and panels in one figure.
CURVES: Final = 3
PANELS: Final = 4
STYLES: Final[tuple[Emphasis, ...]] = ("main", "one of many")

#: What varies by less is no matter of scale.
FLAT: Final = 1.02

#: Marks of the third curve; relative difference up to which curves are drawn as one; letters of a title.
MARKS: Final = 25
ALIKE: Final = 1e-3
LONGEST: Final = 70


def simulate_figures(results: Iterable[SimulateResult]) -> Iterator[Figure]:
    """Yield the figures of every stage that was simulated, then the deviations of several stages together."""
    results = tuple(results)
    for result in results:
        found = result.found
        if isinstance(found, NotComputed):
            continue
        time = result.system.time
        yield from _deviations(result, found)
        if found.mismatch is not None:
            yield from _mismatch(result.title, time, found.mismatch)
        if found.initial is not None:
            yield from _mean(result, found, found.initial)
        if found.monte_carlo is not None and (found.monte_carlo.nees or found.monte_carlo.nis):
            yield _consistency(result.title, time, found.monte_carlo)
    yield from _together([(one, one.found) for one in results if not isinstance(one.found, NotComputed)])


def _together(drawn: Sequence[tuple[SimulateResult, Simulation]]) -> Iterator[Figure]:
    """Yield a panel for every quantity and state, with a curve for every stage that has it."""
    if len(drawn) < 2:
        return
    first, found = drawn[0]
    for one in TOGETHER:
        if sum(one.series(simulation) is not None for _, simulation in drawn) < 2:
            continue
        for kind, name in (("quantity", "quantities"), ("state", "states")):
            panels = [_compared(drawn, form, one) for form in found.forms if form.kind == kind]
            panels = [panel for panel in panels if panel.curves]  # another filter has other states
            file, title = f"{first.model.name}-{one.part}-of-{name}", f"{first.model.name}: {one.title}"
            yield from _figures(file, f"{title} in each stage", first.system.time, panels)


@dataclass(frozen=True, slots=True)
class _Together:
    """What of several stages is drawn together; ``series``: instants, names, values, None: there is none."""

    part: str
    title: str
    axis: str
    logarithmic: bool
    series: Callable[[Simulation], tuple[Array, tuple[str, ...], Array] | None]


def _of_deviations(found: Simulation) -> tuple[Array, tuple[str, ...], Array]:
    return found.history.t, found.history.names, found.history.deviations


def _of_means(found: Simulation) -> tuple[Array, tuple[str, ...], Array] | None:
    response = None if found.initial is None else found.initial.response
    return None if response is None else (response.t, response.names, response.mean)


def _of_runs(found: Simulation) -> tuple[Array, tuple[str, ...], Array] | None:
    runs = found.monte_carlo
    return None if runs is None else (runs.t, runs.names, runs.rms)


TOGETHER: Final = (
    _Together("deviations", "standard deviations", "σ", logarithmic=True, series=_of_deviations),
    _Together("mean", "mean response to the initial error", "error", logarithmic=False, series=_of_means),
    _Together(
        "rms", "root mean square of the errors of random runs", "rms", logarithmic=True, series=_of_runs
    ),
)


def _compared(
    drawn: Sequence[tuple[SimulateResult, Simulation]], form: FollowedForm, what: _Together
) -> Panel:
    curves: list[Curve] = []
    for result, found in drawn:
        series = what.series(found)
        if series is None or form.name not in series[1]:
            continue
        label = result.system.stage or result.model.name
        t, values = series[0], series[2][:, series[1].index(form.name)]
        if what.logarithmic:
            curves += _curve(label, t, values, "main")
        else:
            curves.append(Curve(label, tuple(t.tolist()), tuple(values.tolist()), "main"))
    axis = f"{what.axis} [{form.unit}]" if form.unit else what.axis
    return Panel(form.name, axis, tuple(curves), logarithmic=what.logarithmic and _varies(curves))


def _deviations(result: SimulateResult, found: Simulation) -> Iterator[Figure]:
    """Yield σ against time, with the open loop and what is required, and that of combinations."""
    required = {one.name: one.limit for one in found.demands}
    title = f"{result.title}: standard deviations"
    alone = [k for k, one in enumerate(found.forms) if one.kind == "combination"]
    parts = {"deviations": list(_parts(result.system, found.forms)), "combinations": [[k] for k in alone]}
    for name, groups in parts.items():
        panels = [_panel(found, group, required) for group in groups]
        yield from _figures(f"{result.title}-{name}", title, result.system.time, panels)


def _figures(name: str, title: str, time: str, panels: Sequence[Panel]) -> Iterator[Figure]:
    for k in range(0, len(panels), PANELS):
        part = f"-{k // PANELS + 1}" if len(panels) > PANELS else ""
        yield Figure(name + part, title, time, tuple(panels[k : k + PANELS]))


def _parts(system: System, forms: Sequence[FollowedForm]) -> Iterator[list[int]]:
    """Yield indices of states of one vector, else of one unit, as many as a panel takes; quantities alone."""
    vectors = {state.name: state.vector for state in system.states}
    groups: dict[tuple[str, str], list[int]] = {}
    for k, form in enumerate(forms):
        if form.kind == "combination":
            continue
        together = vectors.get(form.name) or ("" if form.kind == "state" and form.unit else form.name)
        groups.setdefault((form.unit, together), []).append(k)
    for group in groups.values():
        for k in range(0, len(group), CURVES):
            yield group[k : k + CURVES]


def _panel(found: Simulation, indices: Sequence[int], required: Mapping[str, float]) -> Panel:
    """Return the deviations of some forms; open loops, and limits, that coincide are drawn once."""
    history, t = found.history, found.history.t
    curves: list[Curve] = []
    for place, k in enumerate(indices):
        label = history.names[k] if len(indices) > 1 else "Kalman filter"
        curves += _styled(label, t, history.deviations[:, k], place)
    apart: list[Array] = []
    for k in indices:
        own = history.open_loop[:, k]
        if not any(np.allclose(own, other, rtol=ALIKE, atol=0) for other in apart):
            curves += _curve("" if apart else "nothing measured", t, own, "reference")
            apart.append(own)
    names = [history.names[k] for k in indices]
    limits = sorted({required[name] for name in names if name in required})
    ends = (float(t[0]), float(t[-1]))
    curves += [Curve("required", ends, (limit, limit), "limit") for limit in limits]
    title = ", ".join(names)
    title = title if len(title) <= LONGEST else f"{title[:LONGEST]} …"
    unit = found.forms[indices[0]].unit
    return Panel(title, _label(unit), tuple(curves), logarithmic=_varies(curves))


def _varies(curves: Sequence[Curve]) -> bool:
    """Whether a logarithmic scale shows more than the last digits of one number."""
    values = [value for curve in curves for value in curve.y]
    return bool(values) and max(values) > FLAT * min(values)


def _label(unit: str) -> str:
    return f"σ [{unit}]" if unit else "σ"


def _styled(label: str, t: Array, values: Array, place: int) -> Iterator[Curve]:
    """Yield the curve in the style of its place in the panel: black, grey, or a few marks."""
    if place < len(STYLES):
        yield from _curve(label, t, values, STYLES[place])
        return
    few = np.unique(np.linspace(0, len(t) - 1, MARKS).round().astype(int))
    for curve in _curve(label, t[few], values[few], "main"):
        yield replace(curve, marked=True)


def _curve(label: str, t: Array, values: Array, style: Emphasis) -> Iterator[Curve]:
    """Yield the curve as far as it can be drawn on a logarithmic scale."""
    drawn = np.isfinite(values) & (values > 0)
    if drawn.any():
        yield Curve(label, tuple(t[drawn].tolist()), tuple(values[drawn].tolist()), style)


def _mismatch(title: str, time: str, one: Mismatch) -> Iterator[Figure]:
    """Yield for every form what the filter claims and what is true."""
    found = one.history
    units = {state.name: state.unit for state in one.system.states}
    panels = [
        Panel(
            name,
            _label(units.get(name, "")),
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


def _mean(result: SimulateResult, found: Simulation, one: Initial) -> Iterator[Figure]:
    """Yield for every form the mean error, between plus and minus the deviation that the filter claims."""
    mismatch, mean = found.mismatch, one.response
    system = result.system if mismatch is None else mismatch.system
    t, claimed = (
        (found.history.t, found.history.deviations)
        if mismatch is None
        else (mismatch.history.t, mismatch.history.claimed)
    )
    units = {state.name: state.unit for state in system.states}
    panels = [
        Panel(
            name,
            f"error [{units[name]}]" if units.get(name) else "error",
            (
                Curve("mean", tuple(mean.t.tolist()), tuple(mean.mean[:, k].tolist()), "main"),
                Curve("±σ", tuple(t.tolist()), tuple(claimed[:, k].tolist()), "reference"),
                Curve("", tuple(t.tolist()), tuple((-claimed[:, k]).tolist()), "reference"),
            ),
        )
        for k, name in enumerate(mean.names)
    ]
    yield from _figures(f"{result.title}-mean", f"{result.title}: initial error", result.system.time, panels)


def _consistency(title: str, time: str, found: MonteCarlo) -> Figure:
    """Return NEES and NIS against time with their bands."""
    parts = [("NEES", found.nees), ("NIS", found.nis)]
    panels = tuple(_band(name, one, found.confidence) for name, one in parts if one is not None)
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
