"""The two checks that ``verify`` makes of everything it analyses: the certificate, and the Gramian's word."""

from __future__ import annotations

from typing import Final

from obscli.checks.certificate import check_certificate
from obscli.core.check import CheckResult, Indicator, Verdict
from obscli.core.verification import NotVerified, Verification
from obscli.exact.finding import Analysis, Undecided
from obscli.model.system import System


VERDICTS: Final[dict[str, Verdict]] = {
    "verified": "holds",
    "contradicted": "fails",
    "undecided": "undecided",
    "not excited": "undecided",
}


def certified(system: System, finding: Analysis | Undecided) -> CheckResult:
    """Check the proof of the rank."""
    if isinstance(finding, Undecided):
        return CheckResult("the rank can be decided", "undecided", finding.reason)
    if finding.certificate is None:
        return CheckResult("the rank is proved", "undecided", "; ".join(finding.undecided))
    combinations = tuple(one.coefficients for one in finding.combinations)
    return check_certificate(system, finding.certificate, combinations)


def agreed(
    found: Verification | NotVerified, claim: str = "the Gramian agrees with the analysis"
) -> CheckResult:
    """Put the comparison of an analysis with the Gramian into one check."""
    if isinstance(found, NotVerified):
        return CheckResult(claim, "undecided", found.reason)
    worst = found.worst
    chi, bound = (None, None) if worst is None else (worst.chi, worst.bound)
    indicator = Indicator(found.agree, len(found.points), chi, bound)
    reason = found.reason if found.verdict == "verified" else f"{found.reason}: {found.diagnosis}"
    return CheckResult(claim, VERDICTS[found.verdict], reason, gramian=indicator)
