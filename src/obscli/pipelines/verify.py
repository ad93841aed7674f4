"""The work of ``obscli verify``: what models claim, and what the analysis proves, checked and counted."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from obscli.checks.certificate import check_certificate
from obscli.checks.claims import check_claims
from obscli.core.check import CheckResult
from obscli.core.document import Document
from obscli.core.place import Place
from obscli.exact import analysis as engine
from obscli.exact.finding import Undecided
from obscli.model.covector import parse_covector
from obscli.model.system import Claim, Model, System
from obscli.pipelines.describe.checks import check_document
from obscli.pipelines.reading import chosen_systems
from obscli.pipelines.request import Progress, silent
from obscli.pipelines.stage_result import StageChecks
from obscli.pipelines.verify_data import verify_data


@dataclass(frozen=True, slots=True, eq=False)
class VerifyReport:
    """Every check of every stage, in the order they were made."""

    results: tuple[StageChecks, ...]

    @property
    def failed(self) -> int:
        """How many checks failed."""
        return self._count("fails")

    @property
    def undecided(self) -> int:
        """How many checks could not be decided."""
        return self._count("undecided")

    def _count(self, verdict: str) -> int:
        return sum(check.verdict == verdict for result in self.results for check in result.checks)

    def document(self) -> Document:
        """Return the report for a reader: a line a check, then the count."""
        return check_document(self.results)

    def data(self) -> Mapping[str, object]:
        """Return the report for a program."""
        return verify_data(self.results, failed=self.failed, undecided=self.undecided)


def verify(
    models: Iterable[Model],
    stages: tuple[str, ...] = (),
    claims: tuple[str, ...] = (),
    progress: Progress = silent,
) -> VerifyReport:
    """Analyse every stage and check its certificate and everything claimed of it.

    Parameters
    ----------
    models : the models, with the claims of their files
    stages : only these stages; empty: all
    claims : combinations asserted to be observable in every stage, checked instead of the files' own claims
    progress : told what is being done
    """
    results = []
    for model in models:
        later = _later(model)
        for system in chosen_systems(model, stages):
            progress(f"{model.name}: {system.stage or 'base'}")
            results.append(StageChecks(model, system, (*_checks(_with_claims(system, claims)), *later)))
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


def _checks(system: System) -> tuple[CheckResult, ...]:
    finding = engine.analyze(system, engine.Options(critical=False), silent)
    if isinstance(finding, Undecided):
        return (CheckResult("the rank can be decided", "undecided", finding.reason),)
    own = (
        (
            check_certificate(
                system, finding.certificate, tuple(one.coefficients for one in finding.combinations)
            ),
        )
        if finding.certificate is not None
        else (CheckResult("the rank is proved", "undecided", "; ".join(finding.undecided)),)
    )
    return (*own, *check_claims(system, finding))
