"""What ``obscli verify`` checks of an experiment: every run, the matrix M, the joint Gramian, and claims."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from obscli.core.check import CheckResult
from obscli.exact.finding import Analysis
from obscli.experiment.agreement import verify_together
from obscli.experiment.claims import Subject, check_experiment_claims
from obscli.experiment.own_symbols import told_apart
from obscli.experiment.special import at_file
from obscli.experiment.stacked import Memo, RunRows, Stack, analysed
from obscli.experiment.witnessed import witnessed
from obscli.model.system import Claim, Model
from obscli.pipelines.calibrate import experiment_of
from obscli.pipelines.numerical import Looks, settings_of, verify_analysis
from obscli.pipelines.proof_checks import agreed, certified
from obscli.pipelines.request import NumericRequest, Progress, silent
from obscli.pipelines.stage_result import StageChecks


def verify_experiment(
    model: Model, look: Looks, request: NumericRequest, progress: Progress
) -> StageChecks | None:
    """Return the checks of the experiment of a model; None where there is none, and no claim about it."""
    if model.experiment is None and not model.claims:
        return None
    experiment, _ = experiment_of(model)
    progress(f"{model.name}: experiment")
    runs, _ = told_apart(experiment.runs, model.systems[0])
    stack = analysed(runs, experiment.shared, silent, critical=False, base=model.systems[0])
    settings, memo = settings_of(stack.system, request), Memo()
    verification = verify_together(
        stack,
        at_file(stack, experiment.shared, None, memo) if isinstance(stack.finding, Analysis) else None,
        witnessed(runs, stack.system, look.numeric, settings),
    )
    subject = Subject(
        experiment.runs,
        experiment.everything,
        experiment.shared,
        look.numeric,
        settings,
        model.systems[0],
        memo,
    )
    checks = (
        *_run_checks(stack, look),
        replace(certified(stack.system, stack.finding), claim=_matrix(stack)),
        agreed(verification, "the Gramians of all runs together agree with it"),
        *check_experiment_claims(model.claims, subject),
        *(one for claim in model.claims for one in _unmeasured(claim)),
    )
    system = replace(stack.system, stage=experiment.name or "experiment")
    return StageChecks(model, system, checks, verification)


def _unmeasured(claim: Claim) -> Iterator[CheckResult]:
    """Say that measures and stationary systems are those of stages, and which command tells the accuracy."""
    if claim.measures:
        reason = "measures are taken of stages: give `stage` instead of `experiment`"
        yield CheckResult("measures", "undecided", reason, claim.measures[0].place)
    if claim.stationary is not None:
        reason = "stationary systems are those of stages: give `stage` instead of `experiment`"
        yield CheckResult("stationary", "undecided", reason, claim.stationary.place)
    for name, (word, place) in claim.requirements.items():
        reason = (
            "the accuracy of an experiment is told by `obscli calibrate`, which fails where one is missed"
        )
        yield CheckResult(f"the accuracy of {name or 'all'} is {word}", "undecided", reason, place)


def _matrix(stack: Stack) -> str:
    rank = stack.finding.rank if isinstance(stack.finding, Analysis) else "?"
    return f"certificate: M is {stack.system.m} × {stack.system.n} of rank {rank}"


def _run_checks(stack: Stack, look: Looks) -> Iterator[CheckResult]:
    """Yield certificate and Gramian of every run; runs that are the same system once."""
    seen: dict[int, RunRows] = {}
    for one in stack.runs:
        if id(one.run.system) in seen or one.finding is None:
            continue
        seen[id(one.run.system)] = one
        found = certified(one.run.system, one.finding)
        yield replace(found, claim=f"run {one.run.name}: {found.claim}, {len(one.rows)} rows of M")
        numeric = look.numeric(one.run.system)
        yield agreed(
            verify_analysis(one.finding, numeric), f"run {one.run.name}: the Gramian agrees with its analysis"
        )
