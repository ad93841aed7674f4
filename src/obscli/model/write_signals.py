"""``signals`` as text: the files by their whole paths, since nobody knows where the text will be kept."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from obscli.model.write_text import Entry, block_lines, entry_lines, formula, scalar


if TYPE_CHECKING:
    from obscli.model.signal_file import SignalColumn, SignalFile
    from obscli.model.system import System


def signal_lines(system: System) -> Iterator[str]:
    """Yield the section ``signals``: of every file the columns that are functions of the system."""
    names = {one.name for one in system.functions}
    files = [(one, [column for column in one.columns if column.name in names]) for one in system.signals]
    files = [(file, columns) for file, columns in files if columns]
    if not files:
        return
    yield "signals:"
    for file, columns in files:
        yield f"  - file: {scalar(str(file.file.resolve()))}"
        yield from entry_lines("time", _time(file), "    ")
        yield f"    interpolation: {file.interpolation}"
        if file.max_gap is not None:
            yield f"    max_gap: {formula(file.max_gap)}"
        yield "    columns:"
        yield from block_lines([(column.name, _column(column)) for column in columns], "      ")


def _time(file: SignalFile) -> str | list[Entry]:
    entries: list[Entry] = [("column", scalar(file.time))]
    if file.factor is not None:
        entries.append(("factor", formula(file.factor)))
    if file.zero != "value":
        entries.append(("zero", file.zero if isinstance(file.zero, str) else formula(file.zero)))
    return entries


def _column(column: SignalColumn) -> str | list[Entry]:
    entries: list[Entry] = [("column", scalar(column.column))]
    if column.factor is not None:
        entries.append(("factor", formula(column.factor)))
    if column.unwrap is not None:
        entries.append(("unwrap", formula(column.unwrap)))
    return scalar(column.column) if len(entries) == 1 else entries
