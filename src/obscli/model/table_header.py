"""The first line of a table of samples: the names of its columns, and what parts them.

Only this line is read where a model is; the numbers are the numerical side's.
"""

from __future__ import annotations

import csv
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Final


#: Formats by the ending of the name; of the last two the names are known where the numbers are read.
FORMATS: Final = {".csv": "csv", ".txt": "csv", ".tsv": "csv", ".dat": "csv"}
FORMATS_BINARY: Final = {".npz": "npz", ".mat": "mat", ".parquet": "parquet"}
_LONGEST: Final = 1_000_000
_PARTED_BY: Final = (",", ";", "\t")


class TableError(Exception):
    """A table that cannot be read as one: why, and what to do."""

    def __init__(self, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.message = message
        self.hint = hint


@dataclass(frozen=True, slots=True)
class Header:
    """The names of the columns in order, what parts them, and how many lines stand above the numbers.

    ``delimiter``: empty where blanks do.
    """

    names: tuple[str, ...]
    delimiter: str = ""
    lines: int = 1


def format_of(path: Path) -> str:
    """Return ``csv``, ``npz``, ``mat`` or ``parquet``.

    Raises
    ------
    TableError
        where the ending of the name is none that is known
    """
    ending = path.suffix.lower()
    found = FORMATS.get(ending) or FORMATS_BINARY.get(ending)
    if found is None:
        known = ", ".join((*FORMATS, *FORMATS_BINARY))
        raise TableError(f"the ending '{ending}' is none of {known}", "save the samples as CSV")
    return found


def names_in(path: Path) -> tuple[str, ...] | None:
    """Return the names that a file has, None where only the numerical side can tell.

    Raises
    ------
    TableError
        where the file is missing, or not what its ending says
    """
    kind = format_of(path)
    if kind == "csv":
        return header_of(path).names
    if not path.is_file():
        raise TableError("there is no such file", "paths are relative to the model file")
    if kind != "npz":
        return None
    try:
        with zipfile.ZipFile(path) as archive:
            return tuple(name.removesuffix(".npy") for name in archive.namelist())
    except (OSError, zipfile.BadZipFile) as error:
        raise TableError(f"the file is no NumPy archive: {error}") from None


def header_of(path: Path) -> Header:
    """Return the header of a text table.

    The first line that is not empty has the names; a `#` or `%` before them is left out.

    Raises
    ------
    TableError
        where there is no such line
    """
    try:
        with path.open("rb") as stream:
            start = stream.read(_LONGEST)
    except FileNotFoundError:
        raise TableError("there is no such file", "paths are relative to the model file") from None
    except (OSError, ValueError) as error:
        raise TableError(f"the file cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if b"\0" in start:
        raise TableError("the file is no text in UTF-8", "save it as CSV in UTF-8")
    lines = start.decode("utf-8-sig", "replace").splitlines()
    above = next((k for k, line in enumerate(lines) if line.strip(" \t#%,;")), None)
    if above is None:
        raise TableError("the file is empty", "the first line has the names of the columns")
    text = lines[above].strip().lstrip("#%").strip()
    delimiter = next((mark for mark in _PARTED_BY if mark in text), "")
    parts = next(csv.reader([text], delimiter=delimiter)) if delimiter else text.split()
    names = tuple(part.strip() for part in parts)
    if all(_is_number(name) for name in names):
        hint = "put a line with their names on top, as in: t,fx,fy,fz"
        raise TableError(f"line {above + 1} has numbers where the names of the columns are expected", hint)
    return Header(names, delimiter, above + 1)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
