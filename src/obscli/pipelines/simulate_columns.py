"""The histories of a simulation as columns of one table, for files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from obscli.numeric.finding import NotComputed
from obscli.pipelines.simulate_result import SimulateResult, Simulation


if TYPE_CHECKING:
    from obscli.numeric.program import Array
    from obscli.numeric.simulation_finding import Consistency


def history_columns(results: Iterable[SimulateResult]) -> dict[str, list[object]]:
    """Return the histories of all stages as columns of one table, None where a stage has no such value.

    A column ``stage`` comes first where there are several stages, then ``t``.
    """
    found = [(one, _stage_columns(one.found)) for one in results if not isinstance(one.found, NotComputed)]
    names = list(dict.fromkeys(name for _, columns in found for name in columns))
    table: dict[str, list[object]] = {"stage": []} if len(found) > 1 else {}
    table |= {name: [] for name in ("t", *names)}
    for result, columns in found:
        instants = sorted({t for own in columns.values() for t in own})
        if len(found) > 1:
            table["stage"] += [result.system.stage or ""] * len(instants)
        table["t"] += instants
        for name in names:
            own = columns.get(name, {})
            table[name] += [own.get(t) for t in instants]
    return table


def _stage_columns(found: Simulation) -> dict[str, dict[float, float]]:
    """Return every history of a stage by its column's name, each as value by instant."""
    history = found.history
    columns = _named("sigma", history.names, history.t, history.deviations)
    columns |= _named("open_loop", history.names, history.t, history.open_loop)
    if found.mismatch is not None:
        other = found.mismatch.history
        columns |= _named("claimed", other.names, other.t, other.claimed)
        columns |= _named("true", other.names, other.t, other.true)
    if found.initial is not None:
        response = found.initial.response
        columns |= _named("response", response.names, response.t, response.mean)
    runs = found.monte_carlo
    if runs is not None:
        columns |= _named("mean", runs.names, runs.t, runs.mean)
        columns |= _named("rms", runs.names, runs.t, runs.rms)
        for what, one in (("nees", runs.nees), ("nis", runs.nis)):
            columns |= {} if one is None else _of_consistency(what, one)
    return columns


def _of_consistency(what: str, found: Consistency) -> dict[str, dict[float, float]]:
    parts: Mapping[str, Array] = {"": found.average, "_lower": found.lower, "_upper": found.upper}
    return {f"{what}{end}": _by_instant(found.t, values) for end, values in parts.items()}


def _named(what: str, names: Sequence[str], t: Array, values: Array) -> dict[str, dict[float, float]]:
    return {f"{what}_{name}": _by_instant(t, own) for name, own in zip(names, values.T, strict=True)}


def _by_instant(t: Array, values: Array) -> dict[float, float]:
    return dict(zip(t.tolist(), values.tolist(), strict=True))
