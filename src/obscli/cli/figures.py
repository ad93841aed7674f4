"""Figures of a report, drawn into a directory."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from obscli.cli.errors import CommandError


if TYPE_CHECKING:
    from obscli.core.report import Report
    from obscli.pipelines.request import Progress


def draw(report: Report, directory: Path | None, progress: Progress) -> None:
    """Draw every figure of a report as SVG and PNG, those called alike numbered; none without a directory."""
    if directory is None:
        return
    from obscli.render.figure import save  # noqa: PLC0415 - the drawing library is heavy

    progress("figures")
    try:
        directory.mkdir(parents=True, exist_ok=True)
        drawn: Counter[str] = Counter()
        for figure in report.figures():
            drawn[figure.name] += 1
            number = f"-{drawn[figure.name]}" if drawn[figure.name] > 1 else ""
            save(replace(figure, name=figure.name + number), directory)
    except OSError as error:
        raise CommandError(f"--plot {directory}: cannot be written: {error.strerror}") from error
