"""The public Python interface; the command line is written on it.

>>> import obscli
>>> report = obscli.analyze("models/ins_calibration/horizontal.yaml")  # doctest: +SKIP
>>> report.results[0].finding.rank  # doctest: +SKIP
16
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from obscli.core.report import Report
from obscli.model.system import Model
from obscli.pipelines import analyze as analyze_pipeline
from obscli.pipelines import calibrate as calibrate_pipeline
from obscli.pipelines import measures_report, plan_report, simulate_report, verify_report, windows_report
from obscli.pipelines import transform as transform_pipeline
from obscli.pipelines import why as why_pipeline
from obscli.pipelines.reading import load as load_changed
from obscli.pipelines.request import (
    AnalyzeRequest,
    CalibrateRequest,
    Changes,
    MeasuresRequest,
    NumericRequest,
    PlanRequest,
    Progress,
    SimulateRequest,
    TransformRequest,
    WhyRequest,
    WindowsRequest,
    silent,
)
from obscli.render.format import Surface


Source: TypeAlias = str | Path | Model


class Shown:
    """A report that a notebook shows by itself."""

    __slots__ = ()

    def _repr_markdown_(self: Report) -> str:
        from obscli.render.markdown import render  # noqa: PLC0415 - only a notebook pays for it

        return render(self, Surface())

    def _repr_latex_(self: Report) -> str:
        from obscli.render.latex import render  # noqa: PLC0415

        return render(self, Surface())


@dataclass(frozen=True, slots=True, eq=False)
class AnalyzeReport(analyze_pipeline.AnalyzeReport, Shown):
    """What ``analyze`` found: ``results``, one a stage, each with ``finding``; ``document()``; ``data()``."""


@dataclass(frozen=True, slots=True, eq=False)
class CalibrateReport(calibrate_pipeline.CalibrateReport, Shown):
    """What ``calibrate`` found: ``results`` with ``exact``, ``accuracy``; ``document()``; ``data()``."""


@dataclass(frozen=True, slots=True, eq=False)
class PlanReport(plan_report.PlanReport, Shown):
    """What ``plan`` chose: ``results`` with ``plan``, ``accuracy``; ``document()``; ``data()``."""


@dataclass(frozen=True, slots=True, eq=False)
class MeasuresReport(measures_report.MeasuresReport, Shown):
    """What ``measures`` found: ``results``, one a stage, each with ``taken``; ``document()``; ``data()``."""


@dataclass(frozen=True, slots=True, eq=False)
class SimulateReport(simulate_report.SimulateReport, Shown):
    """What ``simulate`` found: ``results``, one a stage, each with ``found``; ``document()``; ``data()``."""


@dataclass(frozen=True, slots=True, eq=False)
class TransformReport(transform_pipeline.TransformReport, Shown):
    """What ``transform`` made: ``results``, one a stage, each with ``finding``; ``text``: the model file."""


@dataclass(frozen=True, slots=True, eq=False)
class WhyReport(why_pipeline.WhyReport, Shown):
    """What ``why`` found: ``results``, one a target and stage; ``document()``; ``data()``."""


@dataclass(frozen=True, slots=True, eq=False)
class WindowsReport(windows_report.WindowsReport, Shown):
    """What ``windows`` found: ``results``, one a stage, each with ``found``; ``document()``; ``data()``."""


@dataclass(frozen=True, slots=True, eq=False)
class VerifyReport(verify_report.VerifyReport, Shown):
    """What ``verify`` checked: ``results``, one a stage, each with ``checks``; ``failed``; ``undecided``."""


def load(
    path: str | Path,
    *,
    settings: Mapping[str, str] | None = None,
    fix: Mapping[str, str] | None = None,
    outputs: Iterable[str] = (),
    without: Iterable[str] = (),
) -> Model:
    """Read a model file.

    Parameters
    ----------
    path : the YAML file
    settings : new nominal values of parameters, ``{"omega": "0.2"}``
    fix : exact substitutions, ``{"omega_ie": "0"}``
    outputs : keep only these outputs; none: all
    without : states to leave out

    Raises
    ------
    ModelError
        with every problem of the file, each with its place.
    """
    return load_changed(path, Changes(settings or {}, fix or {}, tuple(outputs), tuple(without)))


def analyze(
    model: Source,
    *,
    request: AnalyzeRequest = AnalyzeRequest(),  # noqa: B008 - frozen and empty
    changes: Changes = Changes(),  # noqa: B008 - frozen and empty
    progress: Progress = silent,
) -> AnalyzeReport:
    """Find exactly which combinations of the states are observable, in every stage of a model.

    Parameters
    ----------
    model : a model file, or a model read before (then ``changes`` must be empty)
    request : which stages, which basis, whether to search for critical values
    changes : changes to make while reading; with ``fix``, the report says what it changes
    progress : told what is being done
    """
    if isinstance(model, Model):
        if changes != Changes():
            raise TypeError("changes are made while reading: give the path of the model")
        found = analyze_pipeline.analyze(model, request, progress=progress)
    else:
        unfixed = None
        changed = load_changed(model, changes)
        if changes.fix:
            unfixed = load_changed(model, Changes(changes.settings, {}, changes.outputs, changes.without))
        found = analyze_pipeline.analyze(changed, request, changes, unfixed, progress)
    return AnalyzeReport(found.results, found.changes, found.segments)


def calibrate(
    model: Source,
    *,
    request: CalibrateRequest = CalibrateRequest(),  # noqa: B008 - frozen and empty
    changes: Changes = Changes(),  # noqa: B008 - frozen and empty
    progress: Progress = silent,
) -> CalibrateReport:
    """Find what the runs of a model's experiment determine of the states they share, and how well.

    Parameters
    ----------
    model : a model file, or a model read before (then ``changes`` must be empty)
    request : which runs, whether to search for critical values, the options of the Gramians
    changes : changes to make while reading
    progress : told what is being done
    """
    found = calibrate_pipeline.calibrate(_read(model, changes), request, changes, progress)
    return CalibrateReport(found.results, found.changes)


def plan(
    model: Source,
    *,
    request: PlanRequest = PlanRequest(),  # noqa: B008 - frozen and empty
    changes: Changes = Changes(),  # noqa: B008 - frozen and empty
    progress: Progress = silent,
) -> PlanReport:
    """Choose among the candidate runs of a model: the smallest sets, ranked, and how long each run.

    Parameters
    ----------
    model : a model file, or a model read before (then ``changes`` must be empty)
    request : which candidates
    changes : changes to make while reading
    progress : told what is being done
    """
    from obscli.pipelines import plan as plan_pipeline  # noqa: PLC0415 - floating point only where it is used

    found = plan_pipeline.plan(_read(model, changes), request, changes, progress)
    return PlanReport(found.results, found.changes, found.segments)


def measure(
    model: Source,
    *,
    request: MeasuresRequest = MeasuresRequest(),  # noqa: B008 - frozen and empty
    changes: Changes = Changes(),  # noqa: B008 - frozen and empty
    progress: Progress = silent,
) -> MeasuresReport:
    """Measure how well states, quantities and combinations are observable, in every stage of a model.

    Parameters
    ----------
    model : a model file, or a model read before (then ``changes`` must be empty)
    request : which measures, when, in which units
    changes : changes to make while reading
    progress : told what is being done
    """
    from obscli.pipelines.measures import measures as run  # noqa: PLC0415 - floating point only where it is used

    found = run(_read(model, changes), request, changes, progress)
    return MeasuresReport(found.results, found.changes)


def windows(
    model: Source,
    *,
    request: WindowsRequest,
    changes: Changes = Changes(),  # noqa: B008 - frozen and empty
    progress: Progress = silent,
) -> WindowsReport:
    """Find how well states and quantities are observable in windows along the interval, in every stage.

    Parameters
    ----------
    model : a model file, or a model read before (then ``changes`` must be empty)
    request : how long windows are, how far apart, how they are weighed
    changes : changes to make while reading
    progress : told what is being done
    """
    from obscli.pipelines.windows import windows as run  # noqa: PLC0415 - floating point only where it is used

    found = run(_read(model, changes), request, changes, progress)
    return WindowsReport(found.results, found.changes)


def simulate(
    model: Source,
    *,
    request: SimulateRequest = SimulateRequest(),  # noqa: B008 - frozen and empty
    changes: Changes = Changes(),  # noqa: B008 - frozen and empty
    progress: Progress = silent,
    design: Source | None = None,
) -> SimulateReport:
    """Simulate the Kalman filter of every stage of a model: deviations in time, random runs, mismatch.

    Parameters
    ----------
    model : a model file, or a model read before (then ``changes`` must be empty)
    request : which stages, the interval, the samples, the random runs
    changes : changes to make to ``model`` while reading
    progress : told what is being done
    design : the model that the filter was designed on, where that is another
    """
    from obscli.pipelines.simulate import simulate as run  # noqa: PLC0415 - floating point only where it is used

    other = None if design is None else _read(design, Changes())
    found = run(_read(model, changes), request, changes, progress, other)
    return SimulateReport(found.results, found.changes, found.interrupted)


def transform(
    model: Source,
    *,
    request: TransformRequest = TransformRequest(),  # noqa: B008 - frozen and empty
    changes: Changes = Changes(),  # noqa: B008 - frozen and empty
    progress: Progress = silent,
) -> TransformReport:
    """Make a model of the observable combinations, of the Kalman decomposition, or without some states.

    Parameters
    ----------
    model : a model file, or a model read before (then ``changes`` must be empty)
    request : what to make of which stages
    changes : changes to make while reading
    progress : told what is being done
    """
    found = transform_pipeline.transform(_read(model, changes), request, changes, progress)
    return TransformReport(found.results, found.changes)


def why(
    model: Source,
    target: str = "",
    *,
    request: WhyRequest | None = None,
    changes: Changes = Changes(),  # noqa: B008 - frozen and empty
    progress: Progress = silent,
) -> WhyReport:
    """Explain why a state can be estimated, or not, and what would make it observable.

    Parameters
    ----------
    model : a model file, or a model read before (then ``changes`` must be empty)
    target : a state, a vector of states, a quantity, or a combination as text; or in ``request``
    request : the target, the stages, whether numbers are wanted
    changes : changes to make while reading
    progress : told what is being done
    """
    asked = request or WhyRequest(target)
    found = why_pipeline.why(_read(model, changes), asked, changes, progress)
    return WhyReport(found.results, found.changes)


def _read(model: Source, changes: Changes) -> Model:
    if not isinstance(model, Model):
        return load_changed(model, changes)
    if changes != Changes():
        raise TypeError("changes are made while reading: give the path of the model")
    return model


def verify(
    *models: Source,
    stages: Iterable[str] = (),
    claims: Iterable[str] = (),
    numeric: NumericRequest = NumericRequest(),  # noqa: B008 - frozen and empty
    progress: Progress = silent,
) -> VerifyReport:
    """Check what models claim, every certificate of their analysis, and both against the Gramian.

    Parameters
    ----------
    models : model files, or models read before
    stages : only these stages; none: all
    claims : further combinations asserted to be observable, ``"b_g1 - omega*M_g21"``
    numeric : instants, method, accuracy and scaling of the Gramian
    progress : told what is being done
    """
    from obscli.pipelines.verify import verify as run  # noqa: PLC0415 - floating point only where it is used

    read = [model if isinstance(model, Model) else load_changed(model) for model in models]
    found = run(read, tuple(stages), tuple(claims), numeric, progress)
    return VerifyReport(found.results)
