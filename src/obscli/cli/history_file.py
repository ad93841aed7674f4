"""Histories of a simulation as a file for other programs: CSV, Parquet or JSON, complete or not touched."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Final

from obscli.cli.errors import CommandError


if TYPE_CHECKING:
    from obscli.pipelines.simulate_report import SimulateReport


def check_history(file: Path | None) -> None:
    """Refuse a file that could not be written later, before anything is computed.

    Raises
    ------
    CommandError
        where its kind is not known, or pyarrow is not there
    """
    if file is None:
        return
    if file.suffix not in WRITERS:
        raise CommandError(f"--history {file}: the name must end in {', '.join(WRITERS)}")
    if not file.resolve().parent.is_dir():
        raise CommandError(f"--history {file}: there is no directory {file.resolve().parent}")
    if file.suffix == ".parquet":
        from importlib.util import find_spec  # noqa: PLC0415 - only this kind of file needs it

        if find_spec("pyarrow") is None:
            raise CommandError(
                f"--history {file}: Parquet is written by pyarrow, which is not installed: "
                "pip install 'obscli[parquet]', or name a .csv file"
            )


def save_history(report: SimulateReport, file: Path | None) -> None:
    """Write the histories of a report; nothing where no file is named, or no stage was simulated."""
    if file is None or not report.simulated:
        return
    content = WRITERS[file.suffix](report)
    target = file.resolve()
    draft = target.with_name(f".{target.name}.{os.getpid()}")
    try:
        try:
            draft.write_bytes(content)
            draft.replace(target)
        finally:
            draft.unlink(missing_ok=True)
    except OSError as error:
        raise CommandError(f"--history {file}: cannot be written: {error.strerror}") from error


def _csv(report: SimulateReport) -> bytes:
    """Return a line of names, then a line an instant; numbers in full, absent ones empty."""
    columns = report.history_columns()
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*columns.values(), strict=True))
    return text.getvalue().encode()


def _json(report: SimulateReport) -> bytes:
    import json  # noqa: PLC0415

    return (json.dumps(report.history_data(), ensure_ascii=False, allow_nan=False) + "\n").encode()


def _parquet(report: SimulateReport) -> bytes:
    import pyarrow as pa  # noqa: PLC0415 - an optional dependency
    from pyarrow.parquet import write_table  # noqa: PLC0415

    columns: Mapping[str, list[object]] = report.history_columns()
    sink = io.BytesIO()
    write_table(pa.table(dict(columns)), sink)
    return sink.getvalue()


WRITERS: Final[Mapping[str, Callable[[SimulateReport], bytes]]] = {
    ".csv": _csv,
    ".parquet": _parquet,
    ".json": _json,
}
