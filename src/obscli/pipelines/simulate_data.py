"""A simulation as JSON values."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from obscli.core.number import json_number
from obscli.core.version import SCHEMA, VERSION
from obscli.numeric.finding import NotComputed
from obscli.pipelines.analysis_data import model_data
from obscli.pipelines.certificate_data import covector_to_data
from obscli.pipelines.request import Changes
from obscli.pipelines.simulate_result import (
    Demand,
    FollowedForm,
    Initial,
    Mismatch,
    Sampling,
    SimulateResult,
    Simulation,
)


if TYPE_CHECKING:
    from obscli.numeric.feedback import Feedback
    from obscli.numeric.program import Array
    from obscli.numeric.simulation_finding import Consistency, MonteCarlo, TimeToObservability


def simulate_data(results: Iterable[SimulateResult], changes: Changes) -> dict[str, object]:
    """Return ``{schema, obscli, changes, results}``, one entry of ``results`` a stage."""
    return {
        "schema": SCHEMA,
        "obscli": VERSION,
        "changes": changes.data(),
        "results": [_result(result) for result in results],
    }


def history_data(results: Iterable[SimulateResult]) -> dict[str, object]:
    """Return ``{schema, obscli, results}`` with the histories of every stage alone."""
    kept = ("history", "initial", "monte_carlo", "mismatch")
    made = (
        (result, _simulation(result, result.found))
        for result in results
        if not isinstance(result.found, NotComputed)
    )
    return {
        "schema": SCHEMA,
        "obscli": VERSION,
        "results": [
            {"model": model_data(result), **{key: data[key] for key in kept}} for result, data in made
        ],
    }


def _result(result: SimulateResult) -> dict[str, object]:
    found = result.found
    return {
        "model": model_data(result),
        "n": result.system.n,
        "states": list(result.system.state_names),
        "simulate": None if isinstance(found, NotComputed) else _simulation(result, found),
        "not_computed": found.reason if isinstance(found, NotComputed) else "",
    }


def _simulation(result: SimulateResult, found: Simulation) -> dict[str, object]:
    return {
        "interval": {"start": found.start, "stop": found.stop, "default": found.default},
        "interrupted": float(found.history.t[-1]) if result.interrupted else None,
        "samples": found.history.samples,
        "assumed_step": found.assumed_step,
        "sampled_functions": list(found.sampled),
        "signals": list(found.recorded),
        "outputs": [_sampling(one) for one in found.sampling],
        "forms": [_form(one) for one in found.forms],
        "no_verdicts": found.unsaid,
        "history": _history(found),
        "initial": None if found.initial is None else _initial(found.initial),
        "feedback": None if found.feedback is None else _feedback(found.feedback),
        "time_to_observability": {one.name: _time(one) for one in found.times},
        "require": [_demand(one) for one in found.demands],
        "monte_carlo": None if found.monte_carlo is None else _monte_carlo(found.monte_carlo),
        "mismatch": None if found.mismatch is None else _mismatch(found.mismatch, found.initial),
    }


def _sampling(one: Sampling) -> dict[str, object]:
    return {
        "name": one.output,
        "samples": one.samples,
        "every": one.every,
        "longest": one.longest,
        "outages": [{"start": start, "stop": stop} for start, stop in one.outages],
    }


def _form(one: FollowedForm) -> dict[str, object]:
    return {
        "name": one.name,
        "kind": one.kind,
        "unit": one.unit,
        "verdict": one.verdict,
        "coefficients": covector_to_data(one.coefficients),
    }


def _history(simulation: Simulation) -> dict[str, object]:
    found = simulation.history
    own = None if simulation.mismatch is not None else simulation.initial
    return {
        "t": _numbers(found.t),
        "prior": {name: json_number(float(s)) for name, s in zip(found.names, found.prior, strict=True)},
        "standard_deviation": _by_form(found.names, found.deviations),
        "open_loop": _by_form(found.names, found.open_loop),
        "mean": None if own is None else _mean(own),
    }


def _initial(one: Initial) -> dict[str, object]:
    names, before = one.response.names, one.response.before
    return {
        "error": {name: json_number(value) for name, value in one.error.items()},
        "before": {name: json_number(float(value)) for name, value in zip(names, before, strict=True)},
        "t": _numbers(one.response.t),
        "mean": _mean(one),
    }


def _mean(one: Initial) -> dict[str, list[float | str | None]]:
    return _by_form(one.response.names, one.response.mean)


def _feedback(one: Feedback) -> dict[str, object]:
    return {
        "states": None if one.states is None else list(one.states),
        "below": one.below,
        "above": one.above,
    }


def _time(one: TimeToObservability) -> dict[str, object]:
    return {"t": json_number(one.reached), "limit": json_number(one.limit), "because": one.because}


def _demand(one: Demand) -> dict[str, object]:
    return {
        "name": one.name,
        "required": json_number(one.limit),
        "after": json_number(one.after),
        "met": one.is_met,
    }


def _monte_carlo(found: MonteCarlo) -> dict[str, object]:
    return {
        "runs": found.runs,
        "seed": found.seed,
        "confidence": found.confidence,
        "inserted": found.inserted,
        "t": _numbers(found.t),
        "mean": _by_form(found.names, found.mean),
        "rms": _by_form(found.names, found.rms),
        "claimed": _by_form(found.names, found.claimed),
        "nees": None if found.nees is None else _consistency(found.nees),
        "nis": None if found.nis is None else _consistency(found.nis),
    }


def _consistency(found: Consistency) -> dict[str, object]:
    return {
        "t": _numbers(found.t),
        "average": _numbers(found.average),
        "lower": _numbers(found.lower),
        "upper": _numbers(found.upper),
        "inside": json_number(found.inside),
    }


def _mismatch(one: Mismatch, initial: Initial | None) -> dict[str, object]:
    found = one.history
    return {
        "filter": {"name": one.model.name, "file": str(one.model.file), "stage": one.system.stage},
        "ignored": list(found.ignored),
        "t": _numbers(found.t),
        "claimed": _by_form(found.names, found.claimed),
        "true": _by_form(found.names, found.true),
        "mean": None if initial is None else _mean(initial),
        "require": [_demand(own) for own in one.demands],
        "ratio": {
            own.name: {"end": json_number(own.end), "worst": json_number(own.worst), "when": own.when}
            for own in one.ratios
        },
    }


def _numbers(values: Array) -> list[float | str | None]:
    return [json_number(float(value)) for value in values]


def _by_form(names: Sequence[str], values: Array) -> dict[str, list[float | str | None]]:
    """Return the columns of a history, shape (k, r), by form."""
    return {name: _numbers(column) for name, column in zip(names, values.T, strict=True)}
