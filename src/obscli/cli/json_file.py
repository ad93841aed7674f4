"""A JSON file from anyone, read with care."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Final, NoReturn

from obscli.cli.errors import CommandError


#: The report on 300 states takes a few megabytes.
LARGEST: Final = 100_000_000


def read_json(file: Path) -> object:
    """Return what the file holds; whatever is wrong with it is a ``CommandError``."""
    try:
        if file.stat().st_size > LARGEST:
            raise CommandError(f"{file}: larger than {LARGEST // 1_000_000} MB")
        value: object = json.loads(file.read_bytes(), parse_constant=_refuse)
    except OSError as error:
        raise CommandError(f"{file}: cannot be read: {error.strerror}") from error
    except (ValueError, RecursionError) as error:
        grounds = "nested too deeply" if isinstance(error, RecursionError) else str(error)
        raise CommandError(f"{file}: not JSON as obscli writes it: {grounds}") from error
    return value


def _refuse(constant: str) -> NoReturn:
    raise ValueError(f"{constant} is no number")
