"""Checks as JSON values, in the frame that every command's JSON has."""

from __future__ import annotations

from collections.abc import Iterable

from obscli.core.check import CheckResult
from obscli.core.version import SCHEMA, VERSION
from obscli.pipelines.numeric_data import evidence_data, verification_data
from obscli.pipelines.stage_result import StageChecks


def verify_data(results: Iterable[StageChecks], *, failed: int, undecided: int) -> dict[str, object]:
    """Return ``{schema, obscli, results, checks, failed, undecided}``; ``checks`` is flat, a row a check."""
    results = tuple(results)
    return {
        "schema": SCHEMA,
        "obscli": VERSION,
        "results": [_stage(result) for result in results],
        "checks": [_check(result, check) for result in results for check in result.checks],
        "failed": failed,
        "undecided": undecided,
    }


def _stage(result: StageChecks) -> dict[str, object]:
    system = result.system
    count = dict.fromkeys(("holds", "fails", "undecided"), 0)
    for check in result.checks:
        count[check.verdict] += 1
    return {
        "model": {"name": result.model.name, "file": str(result.model.file), "stage": system.stage},
        "n": system.n,
        "m": system.m,
        "states": list(system.state_names),
        "verification": {**count, **(verification_data(result.verification) or {})},
    }


def _check(result: StageChecks, check: CheckResult) -> dict[str, object]:
    return {
        "model": result.model.name,
        "stage": result.system.stage,
        "claim": check.claim,
        "verdict": check.verdict,
        "reason": check.reason,
        "place": None if check.place is None else str(check.place),
        **evidence_data(check),
    }
