"""The findings of the numerical pipeline as plain values, for reports."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from obscli.numeric.analysis import Numeric
from obscli.numeric.echelon import echelon_curves
from obscli.numeric.errors import NotComputableError
from obscli.numeric.excitation import deviations_of, excitation
from obscli.numeric.finding import NumericFinding, NumericPoint, SampledFile, SignalsFinding
from obscli.numeric.signal_units import doubts


def finding_of(numeric: Numeric, *, bases: bool = False, verdicts: bool = True) -> NumericFinding:
    """Return what was found.

    Parameters
    ----------
    bases : with an orthonormal basis of the row space at every instant
    verdicts : with what the Gramian says of every state, which takes a while for large systems
    """
    curves = echelon_curves(numeric) if verdicts else None
    motion = numeric.system.motion
    signals = _signals(numeric)
    hidden = () if signals is None else signals.not_excited
    states = {} if curves is None else curves.states
    return NumericFinding(
        system=numeric.system.system,
        method=numeric.settings.method,
        rtol=numeric.settings.step_error,
        scaling=numeric.scaling,
        start=numeric.horizon.start,
        default=numeric.horizon.origin == "default",
        points=tuple(_point(numeric, i, bases=bases) for i in range(len(numeric.horizon.instants))),
        rank=numeric.rank,
        sampled=motion.names if motion else (),
        window=numeric.window,
        states={
            name: "not excited" if own == "observable" and name in hidden else own
            for name, own in states.items()
        },
        groups=() if curves is None else tuple(group for group in curves.groups if len(group) > 1),
        signals=signals,
    )


def _signals(numeric: Numeric) -> SignalsFinding | None:
    signals = numeric.system.motion.signals if numeric.system.motion else None
    if signals is None:
        return None
    files = tuple(
        SampledFile(one.file, one.names, len(one.t), float(one.t[0]), float(one.t[-1]), one.interpolation)
        for one in signals.files
    )
    system = numeric.system.system
    found = SignalsFinding(files, deviations_of(system), doubts=doubts(system))
    try:
        tested = excitation(numeric)
    except NotComputableError as error:
        return replace(found, reason=str(error))
    if tested is None:
        return found
    return replace(
        found,
        t=tested.t,
        shown=len(tested.ratios),
        clear=tested.clear,
        excited=tested.excited,
        calm=tested.calm,
        ratios=tested.ratios,
        not_excited=tested.not_excited,
    )


def _point(numeric: Numeric, i: int, *, bases: bool) -> NumericPoint:
    spaces = numeric.spaces
    is_root, gap = spaces.gramian.is_root, float(spaces.root_gap[i])
    values = spaces.values[i] if is_root else np.sqrt(spaces.values[i])
    tolerance, forward = float(spaces.tolerance[i]), numeric.horizon.end is not None
    return NumericPoint(
        t=float(spaces.instants[i]),
        start=float(spaces.instants[i] if forward else spaces.gramian.starts[i]),
        rank=int(spaces.rank[i]),
        decided=bool(spaces.decided[i]),
        gap=None if np.isnan(gap) else gap,
        tolerance=tolerance if is_root else float(np.sqrt(tolerance)),
        singular_values=tuple(values.tolist()),
        basis=_basis(numeric, i) if bases else None,
        stop=float(spaces.gramian.starts[i]) if forward else None,
    )


def _basis(numeric: Numeric, i: int) -> tuple[tuple[float, ...], ...]:
    """Return orthonormal rows of the observable row space in the file's units."""
    spaces = numeric.spaces
    rows = spaces.right[i, : spaces.rank[i]] / spaces.gramian.units[i]
    orthonormal, _ = np.linalg.qr(rows.T)
    return tuple(tuple(row) for row in orthonormal.T.tolist())
