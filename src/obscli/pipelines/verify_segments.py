"""What ``obscli verify`` checks of segments: bounds that meet, the Gramian over all of them, and claims.

Algebra and balls decide claims; the Gramian is held against the rank. A claim about generic parameters
needs a generic proof, one ``at: nominal`` a proof at the file's values.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from obscli.checks.claims import Ground, check_claim, where_text
from obscli.core.check import CheckResult
from obscli.exact.analysis import Options, analyze
from obscli.exact.finding import Analysis, Undecided
from obscli.model.specialise import Specialisation, at_nominal
from obscli.model.system import Claim, Model
from obscli.numeric.finding import NotComputed
from obscli.pipelines.proof_checks import certified
from obscli.pipelines.request import NumericRequest, Progress
from obscli.pipelines.segments import segments_result
from obscli.pipelines.segments_result import SegmentsResult
from obscli.pipelines.stage_result import SEGMENTS, StageChecks


def verify_segments(model: Model, request: NumericRequest, progress: Progress) -> StageChecks | None:
    """Return the checks of the segments of a model; None where there are none."""
    if model.segments is None:
        return None
    progress(f"{model.name}: segments")
    whole = replace(request, start=None, stop=None, times=())
    result = segments_result(model, whole)
    checks = (
        *_motion(result),
        *_proof(result),
        _gramian(result),
        *(one for claim in model.segments.claims for one in _claimed(claim, result)),
    )
    system = replace(result.segments.parts[0].system, stage=SEGMENTS)
    return StageChecks(model, system, checks)


def _motion(result: SegmentsResult) -> Iterator[CheckResult]:
    if result.turns:
        yield CheckResult(
            "orientation changes by motion only", "undecided", result.turns[0].text, result.segments.place
        )


def _proof(result: SegmentsResult) -> Iterator[CheckResult]:
    """Yield the rank, proved from both sides, and the certificate of the upper one."""
    if result.rank is None:
        reason = f"between {result.least} and {result.most} of {result.n}"
        yield CheckResult("the rank of the segments is proved", "undecided", reason)
        return
    where = "generic" if result.is_generic else "at the file's values"
    text = f"the segments together show {result.rank} of {result.n} ({where})"
    yield CheckResult(text, "holds", "as many rows are independent, and no more can be")
    if result.proved is not None:
        yield certified(result.proved.system, result.proved)


def _gramian(result: SegmentsResult) -> CheckResult:
    claim = "the Gramian over all segments agrees"
    if isinstance(result.numeric, NotComputed):
        return CheckResult(claim, "undecided", result.numeric.reason)
    if result.seen is None:
        return CheckResult(claim, "undecided", "it decides no rank at the end: no gap")
    if result.is_contradicted:
        return CheckResult(claim, "fails", f"its rank is {result.seen}")
    return CheckResult(claim, "holds", f"its rank is {result.seen}")


def _claimed(claim: Claim, result: SegmentsResult) -> Iterator[CheckResult]:
    """Yield the verdict on every part of a claim."""
    found = _ground(claim, result)
    rest = claim
    if isinstance(found.analysis, Undecided) and claim.rank is not None:
        yield _bounded(claim, result, found.analysis.reason)
        rest = replace(claim, rank=None)
    everyone = {}
    if claim.everything is not None:
        names = result.segments.parts[0].system.state_names
        everyone = dict.fromkeys(names, ("observable", claim.everything))
    yield from check_claim(replace(rest, states={**everyone, **rest.states}), found)


def _bounded(claim: Claim, result: SegmentsResult, reason: str) -> CheckResult:
    """Judge a rank by the bounds, which refute but do not prove it."""
    where = where_text(claim.at)
    text = f"rank {claim.rank}{' at ' + where if where else ''}"
    place = claim.rank_place or claim.place
    least, most = result.least or 0, result.n if result.most is None else result.most
    if claim.at is None:  # generic ranks are not below those at some values
        generic = [one.rank for one in (result.exact, result.outputs) if isinstance(one, Analysis)]
        most = min(generic, default=result.n)
    if isinstance(claim.at, dict) or least <= (claim.rank or 0) <= most:
        return CheckResult(text, "undecided", reason, place)
    return CheckResult(text, "fails", f"it is proved to be from {least} to {most}", place)


def _ground(claim: Claim, result: SegmentsResult) -> Ground:
    """Return the proof that a claim is compared with."""
    found = result.proved
    first = result.segments.parts[0].system
    if found is None:
        return _open(result, "the rank of the segments is not proved")
    if claim.at is None:
        if result.is_generic:
            return Ground(found, Specialisation(found.system, {}), "")
        return _open(result, "proved at the file's values only: say `at: nominal`")
    if claim.at == "nominal":
        there = analyze(at_nominal(found.system).system(), Options(critical=False, structure=False))
        return Ground(there, at_nominal(first), "")
    return _open(result, "claims about segments are generic or `at: nominal`: give other values with --set")


def _open(result: SegmentsResult, reason: str) -> Ground:
    first = result.segments.parts[0].system
    return Ground(Undecided(first, reason), Specialisation(first, {}), "")
