"""Windows as JSON values."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Final

from obscli.core.number import json_number
from obscli.core.version import SCHEMA, VERSION
from obscli.exact.motion import MotionNeeds
from obscli.numeric.finding import NotComputed
from obscli.numeric.piecewise_constant import PiecewiseConstant
from obscli.numeric.program import Array
from obscli.numeric.window_measures import WindowValues
from obscli.numeric.window_scaling import WindowScaling
from obscli.pipelines.analysis_data import model_data
from obscli.pipelines.request import Changes, WindowsRequest
from obscli.pipelines.windows_result import Gain, Windows, WindowsResult


#: The keys of one state in one window, and the fields they come from.
KEYS: Final = {
    "conventional-singular-value": "conventional",
    "equivalent-singular-value": "equivalent",
    "column-norm": "column_norm",
    "residual-index": "residual",
    "posterior-ratio": "posterior",
}


def windows_data(results: Iterable[WindowsResult], changes: Changes) -> dict[str, object]:
    """Return ``{schema, obscli, changes, results}``, one entry of ``results`` a stage."""
    return {
        "schema": SCHEMA,
        "obscli": VERSION,
        "changes": changes.data(),
        "results": [{"model": model_data(one), "measures": _measures(one)} for one in results],
    }


def _measures(result: WindowsResult) -> dict[str, object]:
    found = result.found
    needs = None if result.needs is None else _needs(result.needs)
    if isinstance(found, NotComputed):
        return {"reason": found.reason, "windows": [], "motion": needs}
    horizon, names = found.horizon, found.names
    return {
        "reason": "",
        "interval": {"start": horizon.start, "stop": horizon.stop, "origin": horizon.origin},
        "window": _window(result.request, found),
        "scaling": _scaling(result, found.scaling),
        "windows": _values(found.values, names, result.system.n),
        "gains": [_gain(one) for one in found.gains],
        "piecewise_constant": _segments(found.segments, names),
        "motion": needs,
        "warnings": list(found.warnings),
    }


def _window(request: WindowsRequest, found: Windows) -> dict[str, object]:
    sampling = found.sampling
    return {
        "length": request.length,
        "step": sampling.step,
        "sample_step": sampling.h,
        "samples": sampling.samples,
        "count": sampling.windows,
        "every": found.every,
        "stack": request.stack,
        "frozen": request.frozen,
        "mu": request.weights,
    }


def _scaling(result: WindowsResult, scaling: WindowScaling) -> dict[str, object]:
    units = zip(result.system.state_names, map(float, scaling.units), strict=True)
    return {
        "states": scaling.origin,
        "outputs": "none" if scaling.weights is None else "noise",
        "units": dict(units),
        "without_prior": list(scaling.without_prior),
        "without_noise": list(scaling.without_noise),
    }


def _values(values: WindowValues, names: Sequence[str], n: int) -> list[dict[str, object]]:
    """Return one entry a window; columns become lists first, which is what takes the time."""
    columns = {key: getattr(values, field).tolist() for key, field in KEYS.items()}
    singular = values.singular_values.tolist()
    found = []
    for i, t in enumerate(values.t.tolist()):
        rows = {key: column[i] for key, column in columns.items()}
        found.append(
            {
                "t": t,
                "rank": int(values.rank[i]),
                "decided": bool(values.decided[i]),
                "gap": json_number(float(values.gap[i])),
                "singular_values": singular[i],
                "states": {name: _at(rows, k) for k, name in enumerate(names[:n])},
                "quantities": {name: _at(rows, k) for k, name in enumerate(names[n:], n)},
            }
        )
    return found


def _at(rows: Mapping[str, Sequence[float]], k: int) -> dict[str, object]:
    """Return the values of one linear form; a rule about states says nothing of a quantity."""
    return {key: json_number(row[k]) if k < len(row) else None for key, row in rows.items()}


def _gain(one: Gain) -> dict[str, object]:
    return {
        "target": one.target,
        "by": one.key,
        "best": json_number(one.best),
        "at": one.at,
        "ranges": [list(pair) for pair in one.ranges],
    }


def _segments(found: PiecewiseConstant | NotComputed, names: Sequence[str]) -> dict[str, object]:
    if isinstance(found, NotComputed):
        return {"reason": found.reason}
    return {
        "reason": "",
        "condition_holds": found.holds,
        "decided": found.decided,
        "segments": [
            {
                "start": start,
                "stop": stop,
                "rank": int(rank),
                "condition": json_number(float(residual)),
                "violated": bool(violated),
                "tom_rank": int(total),
                "som_rank": int(stripped),
            }
            for start, stop, rank, residual, violated, total, stripped in zip(
                found.starts.tolist(),
                found.stops.tolist(),
                found.local_rank,
                found.residual,
                found.violated,
                found.total_rank,
                found.stripped_rank,
                strict=True,
            )
        ],
        "tom_singular_values": _list(found.total_values),
        "som_singular_values": _list(found.stripped_values),
        "observable_since": {
            name: json_number(t) for name, t in zip(names, found.since.tolist(), strict=True)
        },
    }


def _list(values: Array) -> list[object]:
    return [json_number(one) for one in values.tolist()]


def _needs(found: MotionNeeds) -> dict[str, object]:
    return {
        "reason": found.reason,
        "rank": found.rank,
        "tried": found.tried,
        "complete": not found.cut,
        "needs": [
            {"target": one.target, "functions": list(one.functions), "not_all": one.kind, "rank": one.rank}
            for one in found.needs
        ],
    }
