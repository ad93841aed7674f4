"""Figures of a report, drawn into a directory."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from obscli.cli.errors import CommandError


if TYPE_CHECKING:
    from obscli.core.report import Report
    from obscli.pipelines.request import Progress


def draw(report: Report, directory: Path | None, progress: Progress) -> None:
    """Draw every figure of a report as SVG and PNG; nothing where no directory is given."""
    if directory is None:
        return
    from obscli.render.figure import save  # noqa: PLC0415 - the drawing library is heavy

    progress("figures")
    try:
        directory.mkdir(parents=True, exist_ok=True)
        for figure in report.figures():
            save(figure, directory)
    except OSError as error:
        raise CommandError(f"--plot {directory}: cannot be written: {error.strerror}") from error
