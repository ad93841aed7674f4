"""JSON values that may come from a stranger, taken apart with the path of whatever is not as it should be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final


#: No text, list, object or count in what obscli writes is larger; a real one stays far below.
LONGEST_TEXT: Final = 1_000_000
LARGEST_COUNT: Final = 100_000


class CertificateError(ValueError):
    """Data that are no certificate of this system: where in them, and why."""


def value_at(data: Mapping[str, object], key: str, path: str) -> object:
    """Return the value of a key that must be there."""
    if key not in data:
        raise CertificateError(f"{path}: key {key!r} is missing")
    return data[key]


def mapping_at(data: object, path: str) -> Mapping[str, object]:
    """Return the data as an object with text keys."""
    if not isinstance(data, dict) or not all(isinstance(key, str) for key in data):
        raise CertificateError(f"{path}: expected an object, found {_kind(data)}")
    if len(data) > LARGEST_COUNT:
        raise CertificateError(f"{path}: more than {LARGEST_COUNT} keys")
    return data


def list_at(data: object, path: str) -> Sequence[object]:
    """Return the data as a list."""
    if not isinstance(data, list):
        raise CertificateError(f"{path}: expected a list, found {_kind(data)}")
    if len(data) > LARGEST_COUNT:
        raise CertificateError(f"{path}: more than {LARGEST_COUNT} entries")
    return data


def text_at(data: object, path: str) -> str:
    """Return the data as text."""
    if not isinstance(data, str):
        raise CertificateError(f"{path}: expected a string, found {_kind(data)}")
    if len(data) > LONGEST_TEXT:
        raise CertificateError(f"{path}: longer than {LONGEST_TEXT} characters")
    return data


def texts_at(data: object, path: str) -> tuple[str, ...]:
    """Return the data as a list of texts."""
    return tuple(text_at(one, f"{path}[{k}]") for k, one in enumerate(list_at(data, path)))


def count_at(data: object, path: str) -> int:
    """Return the data as a whole number that counts something."""
    if not isinstance(data, int) or isinstance(data, bool) or not 0 <= data <= LARGEST_COUNT:
        raise CertificateError(
            f"{path}: expected a whole number from 0 to {LARGEST_COUNT}, found {_kind(data)}"
        )
    return data


def _kind(data: object) -> str:
    match data:
        case None:
            return "null"
        case bool():
            return "true or false"
        case int():
            return f"the number {data}" if abs(data) < 10**20 else "a huge number"
        case float():
            return "a decimal number"
        case str():
            return "a string"
        case list():
            return "a list"
    return "an object"
