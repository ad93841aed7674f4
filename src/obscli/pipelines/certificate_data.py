"""A certificate as JSON values and back; what comes back may come from a stranger."""

from __future__ import annotations

from collections.abc import Mapping

from obscli.core.place import ModelError
from obscli.exact.finding import Certificate, LowerBound, UpperBound
from obscli.model.covector import parse_scalar
from obscli.model.expression import Expression
from obscli.model.notation import to_text
from obscli.model.system import Covector, System
from obscli.pipelines.json_values import (
    CertificateError as CertificateError,  # noqa: PLC0414 - what the functions below raise
)
from obscli.pipelines.json_values import count_at, list_at, mapping_at, text_at, texts_at, value_at


def certificate_to_data(certificate: Certificate) -> dict[str, object]:
    """Return the certificate as plain JSON values, every expression in the grammar of the model file."""
    lower, upper = certificate.lower, certificate.upper
    return {
        "model": certificate.model,
        "rank": certificate.rank,
        "order": certificate.order,
        "lower": {
            "point": dict(lower.point),
            "rows": [[output, order] for output, order in lower.rows],
            "columns": list(lower.columns),
            "midpoint": lower.midpoint,
            "radius": lower.radius,
            "precision": lower.precision,
        },
        "upper": {
            "kernel": [covector_to_data(direction) for direction in upper.kernel],
            "multiplier": [[to_text(entry) for entry in column] for column in upper.multiplier],
            "delay": None if upper.delay is None else covector_to_data(upper.delay),
        },
        "assumes": list(certificate.assumes),
    }


def covector_to_data(covector: Covector) -> dict[str, str]:
    """Return a covector or direction as {state: expression}."""
    return {state: to_text(coefficient) for state, coefficient in covector.items()}


def certificate_from_data(data: object, system: System, path: str = "certificate") -> Certificate:
    """Return the certificate of ``system`` in JSON values that claim to hold one.

    Raises
    ------
    CertificateError
        naming the first place in the data that is not as a certificate has it.
    """
    top = mapping_at(data, path)
    return Certificate(
        model=text_at(value_at(top, "model", path), f"{path}.model"),
        rank=count_at(value_at(top, "rank", path), f"{path}.rank"),
        order=count_at(value_at(top, "order", path), f"{path}.order"),
        lower=_lower(mapping_at(value_at(top, "lower", path), f"{path}.lower"), f"{path}.lower"),
        upper=_upper(mapping_at(value_at(top, "upper", path), f"{path}.upper"), system, f"{path}.upper"),
        assumes=texts_at(value_at(top, "assumes", path), f"{path}.assumes"),
    )


def covector_from_data(data: object, system: System, path: str) -> Covector:
    """Return the covector in JSON values {state: expression}; raises ``CertificateError``."""
    mapping, states = mapping_at(data, path), frozenset(system.state_names)
    for state in mapping:
        if state not in states:
            raise CertificateError(f"{path}: {state!r} is not a state of the model")
    return {state: _expression(value, system, f"{path}.{state}") for state, value in mapping.items()}


def _lower(data: Mapping[str, object], path: str) -> LowerBound:
    point = mapping_at(value_at(data, "point", path), f"{path}.point")
    rows = list_at(value_at(data, "rows", path), f"{path}.rows")
    return LowerBound(
        point={name: text_at(value, f"{path}.point.{name}") for name, value in point.items()},
        rows=tuple(_row(row, f"{path}.rows[{k}]") for k, row in enumerate(rows)),
        columns=texts_at(value_at(data, "columns", path), f"{path}.columns"),
        midpoint=text_at(value_at(data, "midpoint", path), f"{path}.midpoint"),
        radius=text_at(value_at(data, "radius", path), f"{path}.radius"),
        precision=count_at(value_at(data, "precision", path), f"{path}.precision"),
    )


def _row(data: object, path: str) -> tuple[str, int]:
    pair = list_at(data, path)
    if len(pair) != 2:
        raise CertificateError(f"{path}: expected [output, order], found {len(pair)} entries")
    return text_at(pair[0], f"{path}[0]"), count_at(pair[1], f"{path}[1]")


def _upper(data: Mapping[str, object], system: System, path: str) -> UpperBound:
    kernel = list_at(value_at(data, "kernel", path), f"{path}.kernel")
    multiplier = list_at(value_at(data, "multiplier", path), f"{path}.multiplier")
    delay = value_at(data, "delay", path)
    if len(multiplier) != len(kernel):
        raise CertificateError(f"{path}.multiplier: {len(multiplier)} columns for {len(kernel)} directions")
    columns = [f"{path}.multiplier[{k}]" for k in range(len(multiplier))]
    return UpperBound(
        kernel=tuple(covector_from_data(one, system, f"{path}.kernel[{k}]") for k, one in enumerate(kernel)),
        multiplier=tuple(
            _column(one, len(kernel), system, where) for one, where in zip(multiplier, columns, strict=True)
        ),
        delay=None if delay is None else covector_from_data(delay, system, f"{path}.delay"),
    )


def _column(data: object, length: int, system: System, path: str) -> tuple[Expression, ...]:
    entries = list_at(data, path)
    if len(entries) != length:
        raise CertificateError(f"{path}: expected {length} entries, found {len(entries)}")
    return tuple(_expression(entry, system, f"{path}[{k}]") for k, entry in enumerate(entries))


def _expression(data: object, system: System, path: str) -> Expression:
    try:
        return parse_scalar(system, text_at(data, path), path)
    except ModelError as error:
        raise CertificateError(f"{path}: {error.problems[0].message}") from error
