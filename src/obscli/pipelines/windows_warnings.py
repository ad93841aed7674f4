"""What a reader of indices must not miss: units, ties, violated conditions, what is not identifiable."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from obscli.core.number import counted, plain, short
from obscli.model.expression import symbols
from obscli.model.system import System
from obscli.numeric.finding import NotComputed
from obscli.numeric.piecewise_constant import PiecewiseConstant
from obscli.numeric.signal_units import doubts
from obscli.numeric.window_measures import WindowValues
from obscli.numeric.window_scaling import WindowScaling
from obscli.pipelines.request import WindowsRequest


#: So many names are listed.
_MOST: Final = 12


def warnings_of(
    request: WindowsRequest,
    system: System,
    names: Sequence[str],
    values: WindowValues,
    scaling: WindowScaling,
    segments: PiecewiseConstant | NotComputed,
) -> Iterator[str]:
    """Yield the warnings in order of weight."""
    yield from _sample_motion(system)
    yield from doubts(system)
    yield from _unscaled(scaling)
    yield from _undecided(values)
    yield from _not_identifiable(names, values)
    yield from _degenerate(request, values)
    if isinstance(segments, PiecewiseConstant):
        yield from _violated(segments, system.time)


def _sample_motion(system: System) -> Iterator[str]:
    """Warn that values are an example where functions are left open."""
    used = symbols(*system.A.entries.values(), *system.H.entries.values())
    open_ = [one.name for one in system.functions if one.derivative is None and one.name in used]
    names = [name for name in open_ if name not in system.sampled]
    if names:
        verb = "follows" if len(names) == 1 else "follow"
        yield f"{_listed(names)} {verb} a sample motion, no data: the values are an example"


def _unscaled(scaling: WindowScaling) -> Iterator[str]:
    """Warn where numbers compare metres with radians."""
    if scaling.asked and scaling.origin == "none":
        yield (
            "the states are in the file's units and the outputs unweighed, as asked: values of states of "
            "different kinds do not compare"
        )
        return
    if scaling.origin == "none":
        yield (
            f"no scaling given: `noise` has no P0 of {_listed(scaling.without_prior)}, and not every state "
            "has a `scale`; the states are in the file's units, and values of states of different kinds do "
            "not compare"
        )
    if scaling.without_noise:
        yield (
            f"no scaling given: `noise` has no R of {_listed(scaling.without_noise)}; the outputs are "
            "unweighed, and no posterior can be given"
        )


def _undecided(values: WindowValues) -> Iterator[str]:
    open_ones = int((~values.decided).sum())
    if open_ones:
        yield (
            f"the rank of {counted(open_ones, 'window')} is not decided: a direction lies between "
            "information and rounding"
        )


def _not_identifiable(names: Sequence[str], values: WindowValues) -> Iterator[str]:
    """Warn of positive indices of what no window determines by itself."""
    hidden = (values.residual == 0) & (values.equivalent > 0)
    always = [name for k, name in enumerate(names) if hidden[:, k].all()]
    some = [(name, int(hidden[:, k].sum())) for k, name in enumerate(names) if hidden[:, k].any()]
    some = [(name, count) for name, count in some if name not in always]
    meaning = "σ̃ is an average gain, not a test; what a window adds to the prior is p"
    if always:
        yield (
            f"σ̃ is positive, yet by itself no window identifies {_listed(always)} (residual index 0): "
            f"{meaning}"
        )
    if some:
        listed = _listed([f"{name} ({count})" for name, count in some])
        yield (
            f"σ̃ is positive, yet the residual index is 0, in some of {len(values.t)} windows: {listed}: "
            f"{meaning}"
        )


def _degenerate(request: WindowsRequest, values: WindowValues) -> Iterator[str]:
    count = int(values.degenerate.sum())
    if not count:
        return
    where = f"in {count} of {len(values.t)} windows singular values repeat or vanish together"
    if request.weights == "abs":
        yield f"{where}: σ̃ by |v| is no function of the matrix there; --mu squared is"
    yield f"{where}: to which state the conventional rule gives them is arbitrary"


def _violated(segments: PiecewiseConstant, time: str) -> Iterator[str]:
    if segments.holds:
        return
    worst = int((segments.residual / np.maximum(segments.known, 1e-300)).argmax())
    yield (
        f"the condition null(Q_j) ⊂ null(A_j) is violated in {int(segments.violated.sum())} of "
        f"{counted(len(segments.starts), 'segment')} (by {short(segments.residual[worst])} at {time} = "
        f"{plain(float(segments.starts[worst]))}): the stripped matrix (SOM) may show less than there is; "
        "rely on the total one (TOM)"
    )


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names[:_MOST]) + (", …" if len(names) > _MOST else "")
