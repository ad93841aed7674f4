"""The work of ``obscli measures``: how well the states of every stage are observable, by all measures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from obscli.exact.analysis import analyze
from obscli.exact.finding import Undecided
from obscli.exact.why import LIGHT
from obscli.measures.catalogue import BY_KEY
from obscli.measures.covariances import bounds_at, covariances, sampled_instants, shares
from obscli.measures.measure import Found, Measure
from obscli.measures.subject import Subject
from obscli.measures.taking import in_units, ranked, reverses, take
from obscli.model.covector import parse_scalar
from obscli.model.expression import symbols
from obscli.model.specialise import at_nominal
from obscli.model.system import Model, Requirement, System
from obscli.numeric.errors import NotComputableError, UnfitRequestError
from obscli.numeric.finding import NotComputed
from obscli.numeric.horizon import Horizon, horizon_of
from obscli.numeric.numeric_system import NumericSystem, constants_of
from obscli.numeric.program import Array, constant_value
from obscli.numeric.scaling import sizes_of
from obscli.numeric.schedule import schedule_of
from obscli.pipelines.measure_options import Options, chosen_measures, measure_options, thresholds_of
from obscli.pipelines.measure_targets import targets_of
from obscli.pipelines.measures_report import MeasuresReport
from obscli.pipelines.measures_result import Curves, Limit, MeasuresResult, Reordering, Taken
from obscli.pipelines.measures_segments import measure_segments
from obscli.pipelines.numerical import settings_of
from obscli.pipelines.reading import chosen_systems
from obscli.pipelines.request import Changes, MeasureScaling, MeasuresRequest, Progress, RequestError, silent


#: Instants of a curve.
_CURVE: Final = 200

#: Larger systems are not measured again in other units to see whether the ranking changes.
_MOST_STATES: Final = 40


def measures(
    model: Model,
    request: MeasuresRequest = MeasuresRequest(),  # noqa: B008 - frozen and empty
    changes: Changes = Changes(),  # noqa: B008 - frozen and empty
    progress: Progress = silent,
) -> MeasuresReport:
    """Measure how well the states, quantities and combinations of every stage are observable.

    Raises
    ------
    RequestError
        where there is no such stage, measure or option, or the numbers asked for do not fit the system
    ModelError
        where an instant is no expression in the names of the system
    """
    if request.segments:
        return MeasuresReport((_measured_segments(model, request, progress),), changes)
    systems = chosen_systems(model, request.stages)
    return MeasuresReport(tuple(measure_stage(model, one, request, progress) for one in systems), changes)


def _measured_segments(model: Model, request: MeasuresRequest, progress: Progress) -> MeasuresResult:
    """Measure the segments of a model at their end; raises as ``measures``."""
    chosen = chosen_measures(request.select)
    options, thresholds = measure_options(chosen, request.options), thresholds_of(chosen, request.thresholds)
    found = measure_segments(model, request, chosen, options, progress)
    if not isinstance(found.taken, tuple):
        return found
    last = found.taken[-1]
    return replace(found, limits=(*_required(model, last), *_held(last, thresholds)))


def measure_stage(
    model: Model, system: System, request: MeasuresRequest, progress: Progress = silent
) -> MeasuresResult:
    """Measure one stage; raises as ``measures``."""
    chosen = chosen_measures(request.select)
    options, thresholds = measure_options(chosen, request.options), thresholds_of(chosen, request.thresholds)
    progress(system.stage or model.name)
    return _Stage(model, system, request, chosen, options, progress).measured(thresholds)


class _Stage:
    """Measures one stage."""

    def __init__(
        self,
        model: Model,
        system: System,
        request: MeasuresRequest,
        chosen: tuple[Measure, ...],
        options: Options,
        progress: Progress,
    ) -> None:
        self._model = model
        self._system = system
        self._request = request
        self._chosen = chosen
        self._options = options
        self._progress = progress

    def measured(self, thresholds: Mapping[str, float]) -> MeasuresResult:
        """Return the measures at all instants, or why there are none."""
        system, scaling = self._system, self._request.scaling
        result = MeasuresResult(self._model, system, self._chosen, NotComputed(""), scaling, {})
        try:
            horizon = horizon_of(system, settings_of(system, self._request.numeric).wanted)
            units = sizes_of(system, scaling)
            instants = self._instants(horizon)
            numeric = NumericSystem(system, horizon.start, max(horizon.stop, *instants))
        except UnfitRequestError as error:
            raise RequestError(f"{self._model.file}: {error}") from error
        except NotComputableError as error:
            return replace(result, taken=NotComputed(str(error)))
        self._progress("observability matrix")
        there, generic = at_nominal(system).system(), analyze(system, LIGHT)
        analysis = analyze(there, LIGHT)
        if isinstance(analysis, Undecided):
            if isinstance(generic, Undecided) or generic.at_values.rank != generic.rank:
                return replace(result, taken=analysis)
            analysis = generic  # the rank is the same: what is observable for generic values is so at these
        targets = targets_of(system, analysis, generic)
        subjects = [
            Subject(
                system,
                there,
                analysis,
                numeric,
                horizon.start,
                horizon.stop,
                at,
                units,
                targets,
                self._options,
                self._request.step,
            )
            for at in instants
        ]
        taken = tuple(Taken(one, take(one, self._chosen, self._progress)) for one in subjects)
        return replace(
            result,
            taken=taken,
            units=dict(zip(system.state_names, map(float, units), strict=True)),
            horizon=horizon,
            limits=(*_required(self._model, taken[-1]), *_held(taken[-1], thresholds)),
            reordered=tuple(self._reordered(taken[-1])),
            curves=self._curves(taken[-1]) if self._request.curves else None,
            assumed_step=self._assumed_step(taken[-1]),
            sampled=numeric.motion.names if numeric.motion else (),
        )

    def _assumed_step(self, taken: Taken) -> float | None:
        """Return the step between samples that the noise was taken with, where the file does not say."""
        noisy = any(one.basis == "noise" and isinstance(taken.found[one.key], Found) for one in self._chosen)
        if not noisy:
            return None
        subject = taken.subject
        return schedule_of(self._system, subject.start, subject.stop, self._request.step).assumed_step

    def _instants(self, horizon: Horizon) -> list[float]:
        """Return the instants asked for, else the end of the interval."""
        found = sorted({self._instant(text) for text in self._request.at})
        for t in found:
            if self._system.discrete and t != round(t):
                raise UnfitRequestError(
                    f"the instant {t:.6g} is no whole step of a discrete-time model (--at)"
                )
            if t < horizon.start:
                raise UnfitRequestError(
                    f"the instant {t:.6g} is before the start {horizon.start:.6g} (--from)"
                )
        return found or [horizon.stop]

    def _instant(self, text: str) -> float:
        """Return an instant given as an expression."""
        asked, constants = parse_scalar(self._system, text, "--at"), constants_of(self._system)
        unknown_names = sorted(symbols(asked) - constants.keys())
        if unknown_names:
            raise UnfitRequestError(
                f"--at {text}: {', '.join(unknown_names)} has no value that is a constant"
            )
        t = constant_value(asked, constants)
        if not np.isfinite(t):
            raise UnfitRequestError(f"--at {text}: the instant is not finite")
        return t

    def _reordered(self, taken: Taken) -> Iterator[Reordering]:
        """Yield the measures by which the states rank otherwise in other units that the file gives."""
        subject = taken.subject
        if subject.n > _MOST_STATES:
            return
        scaled = [one for one in self._chosen if one.scaled and one.better is not None]
        for other in _other_scalings(self._system, self._request.scaling):
            again = in_units(subject, sizes_of(self._system, other))
            for measure, found in zip(scaled, take(again, scaled).values(), strict=True):
                before = taken.found[measure.key]
                if isinstance(before, Found) and isinstance(found, Found):
                    own, theirs = ranked(subject, measure, before), ranked(again, measure, found)
                    if reverses(own, theirs):
                        yield Reordering(measure.key, tuple(own), tuple(theirs), other)

    def _curves(self, taken: Taken) -> Curves | None:
        """Return the measures from the noise against time; None where there are none."""
        found = {key for key, one in taken.found.items() if isinstance(one, Found)}
        values: dict[str, Array] = {}
        if not found & {"stochastic", "standard-deviation", "cramer-rao"}:
            return None
        self._progress("measures against time")
        t = sampled_instants(taken.subject, _CURVE)
        if found & {"stochastic", "standard-deviation"}:
            known = covariances(taken.subject, t)
            values = {"stochastic": shares(known), "standard-deviation": known.after}
            values = {key: value for key, value in values.items() if key in found}
            values["open-loop"] = known.open_loop
        if "cramer-rao" in found:
            values["cramer-rao"] = bounds_at(taken.subject, t)
        return Curves(t, values)


def _other_scalings(system: System, own: MeasureScaling) -> Iterator[MeasureScaling]:
    names: tuple[MeasureScaling, ...] = ("none", "prior", "scale")
    for other in names:
        try:
            sizes = sizes_of(system, other)
        except NotComputableError:
            continue
        if other != own and not np.array_equal(sizes, sizes_of(system, own)):
            yield other


def _required(model: Model, taken: Taken) -> Iterator[Limit]:
    """Yield the model's requirements on the deviation."""
    if "standard-deviation" not in taken.found:
        return
    for one in model.require:
        limit = _limit_value(one, taken)
        value = taken.value("standard-deviation", one.name)
        yield Limit("standard-deviation", one.name, limit, value, None if value is None else value <= limit)


def _limit_value(one: Requirement, taken: Taken) -> float:
    return constant_value(one.value, constants_of(taken.subject.system))


def _held(taken: Taken, thresholds: Mapping[str, float]) -> Iterator[Limit]:
    """Yield the states and quantities held against thresholds.

    The number of what is not observable means nothing where larger is better: it is missed.
    """
    for key, limit in thresholds.items():
        found = taken.found[key]
        larger = BY_KEY[key].better == "larger"
        for k, target in enumerate(taken.subject.targets):
            value = found.targets[k] if isinstance(found, Found) else None
            if target.kind == "combination" or (value is None and isinstance(found, Found)):
                continue
            met = None if value is None else value >= limit if larger else value <= limit
            yield Limit(key, target.name, limit, value, met and not (larger and target.observable is False))
