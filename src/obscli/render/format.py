"""What an output format is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from obscli.core.report import Report


@dataclass(frozen=True, slots=True)
class Surface:
    """Where a report will be read: columns of the terminal; whether colour, details, figures are shown."""

    width: int = 100
    colour: bool = False
    details: bool = False
    figures: bool = False


Render: TypeAlias = Callable[[Report, Surface], str]


@dataclass(frozen=True, slots=True)
class Format:
    """An output format: its name on the command line and the function from a report to text."""

    name: str
    render: Render
