"""The work of ``obscli verify``: what models claim and what the analysis proves, by algebra and Gramian."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Final

from obscli.checks.certificate import check_certificate
from obscli.checks.claims import check_claims
from obscli.core.check import CheckResult, Indicator, Verdict
from obscli.core.place import Place
from obscli.core.verification import NotVerified, Verification
from obscli.exact import analysis as engine
from obscli.exact.finding import Analysis, Undecided
from obscli.model.covector import parse_covector
from obscli.model.system import Claim, Model, System
from obscli.pipelines.numerical import Looks, verify_analysis
from obscli.pipelines.reading import chosen_systems
from obscli.pipelines.request import NumericRequest, Progress, silent
from obscli.pipelines.stage_result import StageChecks
from obscli.pipelines.verify_report import VerifyReport


VERDICTS: Final[dict[str, Verdict]] = {
    "verified": "holds",
    "contradicted": "fails",
    "undecided": "undecided",
}


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
    stages : only these stages; empty: all
    claims : combinations asserted to be observable in every stage, checked instead of the files' own claims
    numeric : how the Gramian is to be found
    progress : told what is being done
    """
    results = []
    for model in models:
        later = _later(model)
        for system in chosen_systems(model, stages):
            progress(f"{model.name}: {system.stage or 'base'}")
            found = _checked(model, _with_claims(system, claims), numeric)
            results.append(replace(found, checks=(*found.checks, *later)))
            later = ()
    return VerifyReport(tuple(results))


def _later(model: Model) -> tuple[CheckResult, ...]:
    """Say of claims about experiments that nothing checks them yet."""
    return tuple(
        CheckResult(f"claim about experiment {one.experiment}", "undecided", "not checked yet", one.place)
        for one in model.claims
    )


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


def _checked(model: Model, system: System, request: NumericRequest) -> StageChecks:
    finding = engine.analyze(system, engine.Options(critical=False), silent)
    look = Looks(model, request)
    verification = verify_analysis(finding, look.numeric(system))
    checks = (_certified(system, finding), _agreed(verification), *check_claims(system, finding, look))
    return StageChecks(model, system, checks, verification)


def _certified(system: System, finding: Analysis | Undecided) -> CheckResult:
    """Check the proof of the rank."""
    if isinstance(finding, Undecided):
        return CheckResult("the rank can be decided", "undecided", finding.reason)
    if finding.certificate is None:
        return CheckResult("the rank is proved", "undecided", "; ".join(finding.undecided))
    combinations = tuple(one.coefficients for one in finding.combinations)
    return check_certificate(system, finding.certificate, combinations)


def _agreed(found: Verification | NotVerified) -> CheckResult:
    """Put the comparison of the analysis with the Gramian into one check."""
    claim = "the Gramian agrees with the analysis"
    if isinstance(found, NotVerified):
        return CheckResult(claim, "undecided", found.reason)
    worst = found.worst
    chi, bound = (None, None) if worst is None else (worst.chi, worst.bound)
    indicator = Indicator(found.agree, len(found.points), chi, bound)
    reason = found.reason if found.verdict == "verified" else f"{found.reason}: {found.diagnosis}"
    return CheckResult(claim, VERDICTS[found.verdict], reason, gramian=indicator)
