"""Segments as JSON values."""

from __future__ import annotations

import math

from obscli.core.number import json_number
from obscli.exact.finding import Analysis, Undecided
from obscli.model.system import System
from obscli.pipelines.analysis_data import combination_data
from obscli.pipelines.certificate_data import certificate_to_data, covector_to_data
from obscli.pipelines.numeric_data import numeric_data
from obscli.pipelines.segments_result import SegmentEnd, SegmentsResult


def segments_data(result: SegmentsResult | None) -> dict[str, object]:
    """Return ``{"segments": …}``; nothing where there are none."""
    if result is None:
        return {}
    system = result.segments.parts[0].system
    certified = result.certified
    return {
        "segments": {
            "model": {"name": result.model.name, "file": str(result.model.file)},
            "n": result.n,
            "states": list(system.state_names),
            "rank": result.rank,
            "generic": result.is_generic,
            "at_least": result.least,
            "at_most": result.most,
            "reason": certified.reason if certified else "",
            "parts": [_end(one) for one in result.ends],
            "bound": _bound(result.exact, system),
            "outputs_from_start": _bound(result.outputs, system),
            "bound_at_values": _bound(result.there, system),
            "numeric": numeric_data(result.numeric),
            "contradicted": result.is_contradicted,
            "warnings": [one.text for one in result.turns],
        }
    }


def _end(one: SegmentEnd) -> dict[str, object]:
    timed = not math.isnan(one.stop)
    return {
        "name": one.name,
        "start": one.start if timed else None,
        "stop": one.stop if timed else None,
        "jump": one.jumps,
        "at_least": one.proved,
        "rank": one.rank,
        "decided": one.decided,
        "gap": json_number(one.gap),
    }


def _bound(found: Analysis | Undecided | None, system: System) -> dict[str, object] | None:
    """Return the constant directions hidden all the way, and the combinations that are zero on them."""
    if found is None:
        return None
    if isinstance(found, Undecided):
        return {"rank": None, "reason": found.reason}
    return {
        "rank": found.rank,
        "combinations": [combination_data(one.coefficients, system) for one in found.combinations],
        "unobservable": [{"coefficients": covector_to_data(one)} for one in found.unobservable],
        "states": dict(found.states),
        "quantities": {one.name: one.verdict for one in found.quantities},
        "certificate": None if found.certificate is None else certificate_to_data(found.certificate),
        "reason": "; ".join(found.undecided),
    }
