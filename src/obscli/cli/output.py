"""Where a report goes: standard output, or a file that is either complete or not touched."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path
from typing import Final, TextIO

from obscli.cli.errors import CommandError
from obscli.core.report import Report
from obscli.render.format import Surface
from obscli.render.formats import format_named


#: Columns where there is no terminal and no COLUMNS, and the widest a report is set.
DEFAULT_WIDTH: Final = 100
WIDEST: Final = 120

#: Signs for an output that has none of Unicode's.
PLAIN_SIGNS: Final = str.maketrans(
    {
        "●": "*",
        "◐": "o",
        "·": ".",
        "✓": "+",
        "✗": "x",
        "•": "-",
        "─": "-",
        "≥": ">=",
        "≤": "<=",
        "–": "-",
        "—": "-",
    }
)


def deliver(
    report: Report, form: str, file: Path | None, *, details: bool = False, figures: bool = False
) -> None:
    """Render the report and write it where the user wants it, with figures where the format can."""
    text = format_named(form).render(report, _surface(file, details=details, figures=figures))
    write(text, file)


def write(text: str, file: Path | None) -> None:
    """Write text to a file, or to standard output."""
    if file is None:
        _print(text)
    else:
        _save(text, file)


def _surface(file: Path | None, *, details: bool, figures: bool = False) -> Surface:
    width = min(shutil.get_terminal_size((DEFAULT_WIDTH, 24)).columns, WIDEST)
    terminal = file is None and sys.stdout.isatty()
    plain = bool(os.environ.get("NO_COLOR")) or os.environ.get("TERM") == "dumb"
    return Surface(width=width, colour=terminal and not plain, details=details, figures=figures)


def _print(text: str) -> None:
    """Write to standard output; a reader that has seen enough (``| head``) is no error."""
    try:
        sys.stdout.write(_encodable(text, sys.stdout))
        sys.stdout.flush()
    except BrokenPipeError:
        _give_up_stdout()
    except OSError as error:
        _give_up_stdout()
        raise CommandError(f"standard output cannot be written: {error.strerror}") from error


def _give_up_stdout() -> None:
    """Put a sink in place of standard output, for Python's own last flush."""
    sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115, PTH123


def _encodable(text: str, stream: TextIO) -> str:
    encoding = stream.encoding or "utf-8"
    try:
        text.encode(encoding)
    except UnicodeEncodeError:
        return text.translate(PLAIN_SIGNS).encode(encoding, "backslashreplace").decode(encoding)
    return text


def _save(text: str, file: Path) -> None:
    target = file.resolve()
    try:
        if target.exists() and not target.is_file():
            target.write_text(text, encoding="utf-8")
            return
        draft = target.with_name(f".{target.name}.{os.getpid()}")
        try:
            draft.write_text(text, encoding="utf-8", newline="\n")
            draft.replace(target)
        finally:
            draft.unlink(missing_ok=True)
    except OSError as error:
        missing = "" if target.parent.is_dir() else f" (there is no directory {target.parent})"
        raise CommandError(f"--output {file}: cannot be written: {error.strerror}{missing}") from error
