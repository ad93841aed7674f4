"""Certificates in a JSON report of ``obscli analyze``, checked against the model they claim to be about."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from obscli.checks.certificate import check_certificate
from obscli.core.check import CheckResult
from obscli.core.place import ModelError
from obscli.exact.finding import Certificate
from obscli.model.specialise import at_nominal
from obscli.model.system import Covector, Model, System
from obscli.pipelines.certificate_data import certificate_from_data, covector_from_data
from obscli.pipelines.freezing import frozen_system
from obscli.pipelines.json_values import CertificateError, list_at, mapping_at, text_at, texts_at, value_at
from obscli.pipelines.request import Changes, Progress, RequestError, silent
from obscli.pipelines.stage_result import StageChecks
from obscli.pipelines.verify_report import VerifyReport


def recorded_changes(data: object) -> Changes:
    """Return the changes under which a report was made, so that the same system is read again."""
    top = mapping_at(data, "report")
    if "changes" not in top:
        return Changes()
    changes = mapping_at(top["changes"], "changes")
    return Changes(
        settings=_texts_by_name(value_at(changes, "set", "changes"), "changes.set"),
        fix=_texts_by_name(value_at(changes, "fix", "changes"), "changes.fix"),
        outputs=texts_at(value_at(changes, "outputs", "changes"), "changes.outputs"),
        without=texts_at(value_at(changes, "without", "changes"), "changes.without"),
    )


def _texts_by_name(data: object, path: str) -> dict[str, str]:
    return {name: text_at(value, f"{path}.{name}") for name, value in mapping_at(data, path).items()}


def verify_certificates(
    model: Model, data: object, stages: tuple[str, ...] = (), progress: Progress = silent
) -> VerifyReport:
    """Check the certificate of every result (of the named stages) against the stage of the same name.

    Raises
    ------
    CertificateError
        where the data are no report, or none of its results is about a stage asked for.
    """
    results = []
    for k, entry in enumerate(list_at(value_at(mapping_at(data, "report"), "results", "report"), "results")):
        path = f"results[{k}]"
        result = mapping_at(entry, path)
        system = _system(model, mapping_at(value_at(result, "model", path), f"{path}.model"), path)
        if result.get("frozen") is not None:
            frozen = f"{path}.frozen"
            system = _frozen(system, mapping_at(result["frozen"], frozen), frozen)
        if not stages or system.stage in stages:
            progress(f"certificate of {system.stage or model.name}")
            results.append(StageChecks(model, system, tuple(_checks(system, result, path))))
    if not results:
        raise CertificateError(
            "results: no result to check" + (f" for {', '.join(stages)}" if stages else "")
        )
    return VerifyReport(tuple(results))


def _system(model: Model, identity: Mapping[str, object], path: str) -> System:
    stage = value_at(identity, "stage", f"{path}.model")
    for system in model.systems:
        if system.stage == stage:
            return system
    named = "the base system" if stage is None else f"a stage {text_at(stage, f'{path}.model.stage')!r}"
    raise CertificateError(f"{path}.model.stage: {model.file} has no such stage: {named}")


def _frozen(system: System, frozen: Mapping[str, object], path: str) -> System:
    instant = text_at(value_at(frozen, "at", path), f"{path}.at")
    try:
        return frozen_system(system, instant)
    except (RequestError, ModelError) as error:
        raise CertificateError(f"{path}.at: {error}") from error


def _checks(system: System, result: Mapping[str, object], path: str) -> Iterator[CheckResult]:
    """Check the generic certificate with the combinations beside it, and the one at the values, if any."""
    path = f"{path}.analytic"
    analytic = mapping_at(value_at(result, "analytic", path) or {}, path)
    if analytic.get("certificate") is None:
        yield CheckResult(
            "the rank is certified", "undecided", "the report holds no certificate for this stage"
        )
        return
    yield _check(system, analytic, path, _combinations(analytic, system, path))
    at_values = mapping_at(analytic.get("at_values") or {}, f"{path}.at_values")
    if at_values.get("certificate") is not None:
        check = _check(at_nominal(system).system(), at_values, f"{path}.at_values", None)
        yield replace(check, claim=f"{check.claim}, at the file's values")


def _check(
    system: System, found: Mapping[str, object], path: str, combinations: tuple[Covector, ...] | None
) -> CheckResult:
    certificate = certificate_from_data(found["certificate"], system, f"{path}.certificate")
    mismatch = _mismatch(found, certificate)
    if mismatch:
        return CheckResult(f"certificate: rank {certificate.rank}", "fails", mismatch)
    return check_certificate(system, certificate, combinations)


def _mismatch(found: Mapping[str, object], certificate: Certificate) -> str:
    """Say where the report beside the certificate differs from it."""
    for key, certified in (("rank", certificate.rank), ("order", certificate.order)):
        if key in found and found[key] != certified:
            return f"the report says {key} {found[key]}, its certificate {certified}"
    return ""


def _combinations(analytic: Mapping[str, object], system: System, path: str) -> tuple[Covector, ...] | None:
    if "combinations" not in analytic:
        return None
    entries = list_at(analytic["combinations"], f"{path}.combinations")
    covectors = []
    for k, entry in enumerate(entries):
        where = f"{path}.combinations[{k}]"
        coefficients = value_at(mapping_at(entry, where), "coefficients", where)
        covectors.append(covector_from_data(coefficients, system, f"{where}.coefficients"))
    return tuple(covectors)
