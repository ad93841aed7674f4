"""The work of ``obscli verify``: what models claim and what the analysis proves, by algebra and Gramian."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from obscli.checks.claims import check_claims
from obscli.core.place import Place
from obscli.exact import analysis as engine
from obscli.model.covector import parse_covector
from obscli.model.system import Claim, Model, System
from obscli.pipelines.numerical import Looks, verify_analysis
from obscli.pipelines.proof_checks import agreed, certified
from obscli.pipelines.reading import chosen_systems
from obscli.pipelines.request import NumericRequest, Progress, silent
from obscli.pipelines.stage_result import StageChecks
from obscli.pipelines.verify_experiment import verify_experiment
from obscli.pipelines.verify_measures import check_measures
from obscli.pipelines.verify_report import VerifyReport
from obscli.pipelines.verify_segments import verify_segments
from obscli.pipelines.verify_stationary import check_stationary


def verify(
    models: Iterable[Model],
    stages: tuple[str, ...] = (),
    claims: tuple[str, ...] = (),
    numeric: NumericRequest = NumericRequest(),  # noqa: B008 - frozen and empty
    progress: Progress = silent,
) -> VerifyReport:
    """Analyse every stage, check its certificate, hold it and everything claimed against the Gramian.

    Parameters
    ----------
    models : the models, with the claims of their files
    stages : only these stages, and not the experiment; empty: all
    claims : combinations asserted to be observable in every stage, checked instead of the files' own claims
    numeric : how the Gramian is to be found
    progress : told what is being done
    """
    results = []
    for model in models:
        look = Looks(model, numeric)
        for system in chosen_systems(model, stages):
            progress(f"{model.name}: {system.stage or 'base'}")
            results.append(_checked(model, _with_claims(system, claims), look))
        if not stages and not claims:
            experiment = verify_experiment(model, look, numeric, progress)
            segments = verify_segments(model, numeric, progress)
            results += [one for one in (experiment, segments) if one is not None]
    return VerifyReport(tuple(results))


def _with_claims(system: System, texts: tuple[str, ...]) -> System:
    if not texts:
        return system
    added = tuple(
        Claim(
            origin="claims",
            place=Place("--claim", 1, 1, max(len(text), 1)),
            stage=system.stage,
            observable=(parse_covector(system, text, "--claim"),),
        )
        for text in texts
    )
    return replace(system, claims=added)


def _checked(model: Model, system: System, look: Looks) -> StageChecks:
    finding = engine.analyze(system, engine.Options(critical=False), silent)
    verification = verify_analysis(finding, look.numeric(system))
    checks = (
        certified(system, finding),
        agreed(verification),
        *check_claims(system, finding, look),
        *check_stationary(system, finding),
        *(one for claim in system.claims for one in check_measures(model, system, claim)),
    )
    return StageChecks(model, system, checks, verification)
