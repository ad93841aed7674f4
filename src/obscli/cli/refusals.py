"""Requests that the library refuses, as wrong usage of the command line."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from obscli.cli.errors import CommandError
from obscli.pipelines.json_values import CertificateError
from obscli.pipelines.request import RequestError


@contextmanager
def refusals() -> Iterator[None]:
    """Turn the library's refusals into ``CommandError``."""
    try:
        yield
    except (RequestError, CertificateError) as error:
        raise CommandError(str(error)) from error
