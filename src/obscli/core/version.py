"""The version of this package and of the JSON it writes."""

from __future__ import annotations

from typing import Final


#: As in pyproject.toml (a test compares the two; importlib.metadata would cost start-up time).
VERSION: Final = "0.1.0"

#: Frame and meaning of the JSON; the number grows when a key is renamed or dropped.
SCHEMA: Final = "obscli/1"
