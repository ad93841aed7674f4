"""Tables of samples read from files: times and columns as arrays, checked.

CSV by NumPy's own reader (about 10⁶ rows a second); `.npz` and `.mat` by variable; Parquet where pyarrow is
installed.
"""

from __future__ import annotations

import csv
import warnings
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Any, Final

import numpy as np

from obscli.model.signals import variable_of
from obscli.model.table_header import Header, TableError, format_of, header_of
from obscli.numeric.errors import NotComputableError
from obscli.numeric.program import Array


FEWEST: Final = 2

#: So many rows are looked at for cells without a name.
_LOOKED_AT: Final = 100

#: What a file is by its ending.
_KINDS: Final = {"npz": "a NumPy archive", "mat": "a MATLAB file", "parquet": "a Parquet file"}


def read_columns(path: Path, names: Sequence[str]) -> Array:
    """Return the columns of a file, in the order of the names, shape (len(names), N).

    Raises
    ------
    NotComputableError
        where the file is not as the model says: what is wrong, and in which line
    """
    try:
        kind = format_of(path)
        if kind == "csv":
            return _csv(path, header_of(path), names)
    except TableError as error:
        raise NotComputableError(f"{path.name}: {error}") from None
    try:
        variables = {"npz": _npz, "mat": _mat, "parquet": _parquet}[kind](path, names)
    except NotComputableError:
        raise
    except Exception as error:  # noqa: BLE001 - readers of damaged bytes end in whatever these lead them to
        raise NotComputableError(f"{path.name} cannot be read as {_KINDS[kind]}: {error}") from None
    return _stacked(path, variables, names)


def _csv(path: Path, header: Header, names: Sequence[str]) -> Array:
    unknown = [name for name in names if name not in header.names]
    if unknown:
        raise NotComputableError(f"{path.name} has no column '{unknown[0]}'")
    places = [header.names.index(name) for name in names]
    _require_cells(path, header)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # no rows: told by who counts them
            found = np.loadtxt(
                path,
                delimiter=header.delimiter or None,
                skiprows=header.lines,
                usecols=places,
                ndmin=2,
                comments="#",
                encoding="utf-8-sig",
            )
    except (ValueError, IndexError, UnicodeDecodeError) as error:
        reason = _unreadable_line(path, header, names, places) or f"{path.name}: {error}"
        raise NotComputableError(reason) from None
    return np.ascontiguousarray(found.reshape(-1, len(names)).T)


def _require_cells(path: Path, header: Header) -> None:
    """Refuse a table whose first rows have more cells than there are names: which is which is not known."""
    for number, cells in islice(_rows(path, header), _LOOKED_AT):
        filled = max((k for k, cell in enumerate(cells, 1) if cell.strip()), default=0)
        if filled > len(header.names):
            raise NotComputableError(
                f"{path.name}, line {number}: there are {filled} cells, and {len(header.names)} names of "
                "columns: name every column, and write decimals after a point"
            )


def _rows(path: Path, header: Header) -> Iterator[tuple[int, list[str]]]:
    """Yield the rows below the header that are not empty, with their lines."""
    with path.open(encoding="utf-8-sig", errors="replace", newline="") as stream:
        for number, line in enumerate(stream, 1):
            text = line.split("#")[0].strip()
            if number > header.lines and text:
                yield (
                    number,
                    next(csv.reader([text], delimiter=header.delimiter))
                    if header.delimiter
                    else text.split(),
                )


def _unreadable_line(path: Path, header: Header, names: Sequence[str], places: Sequence[int]) -> str:
    """Return what is wrong in the first line that is no row of numbers; empty where nothing is found."""
    for number, cells in _rows(path, header):
        for name, place in zip(names, places, strict=True):
            if place >= len(cells):
                return f"{path.name}, line {number}: there are {len(cells)} cells, and none for '{name}'"
            problem = _no_number(cells[place].strip())
            if problem:
                return f"{path.name}, line {number}, column '{name}': {problem}"
    return ""


def _no_number(cell: str) -> str:
    try:
        float(cell)
    except ValueError:
        pass
    else:
        return ""
    if not cell:
        return "the cell is empty: leave out the line, or give the column a file of its own"
    if cell.count(",") == 1:
        return f"'{cell[:30]}' is no number: write the decimals after a point"
    return f"'{cell[:30]}' is no number: leave out the line, or give the column a file of its own"


def _npz(path: Path, names: Sequence[str]) -> Mapping[str, Any]:
    with path.open("rb") as stream:  # a file that NumPy opens itself stays open where it is no archive
        archive = np.load(stream, allow_pickle=False)
        if not isinstance(archive, np.lib.npyio.NpzFile):
            raise NotComputableError(f"{path.name} holds one array without a name: save it by np.savez")
        wanted = {variable_of(name)[0] for name in names} | set(names)
        return {name: archive[name] for name in archive.files if name in wanted}


def _mat(path: Path, names: Sequence[str]) -> Mapping[str, Any]:
    from scipy.io import loadmat  # noqa: PLC0415 - for this format only

    wanted = {variable_of(name)[0] for name in names} | set(names)
    found = loadmat(path, variable_names=sorted(wanted))
    return {name: value for name, value in found.items() if name in wanted}


def _parquet(path: Path, names: Sequence[str]) -> Mapping[str, Any]:
    try:
        from pyarrow import parquet  # noqa: PLC0415 - an extra
    except ImportError:
        raise NotComputableError(
            f"{path.name}: Parquet files need pyarrow: install obscli[parquet], or save the samples as CSV"
        ) from None
    known = set(parquet.ParquetFile(path).schema_arrow.names)
    table = parquet.read_table(path, columns=[name for name in names if name in known])
    return {name: table[name].to_numpy() for name in table.column_names}


def _stacked(path: Path, variables: Mapping[str, Any], names: Sequence[str]) -> Array:
    found = [_variable(path, variables, name) for name in names]
    lengths = {len(one) for one in found}
    if len(lengths) > 1:
        told = ", ".join(f"{name}: {len(one)}" for name, one in zip(names, found, strict=True))
        raise NotComputableError(f"{path.name}: the columns are of different lengths ({told})")
    return np.array(found)


def _variable(path: Path, variables: Mapping[str, Any], name: str) -> Array:
    """Return a column: a vector, or one column of a matrix as in ``f[2]``."""
    of, index = (name, None) if name in variables else variable_of(name)
    if of not in variables:
        raise NotComputableError(f"{path.name} has no variable '{of}'")
    values = np.squeeze(np.asarray(variables[of]))
    if index is not None and values.ndim == 2:
        values = values if values.shape[0] > values.shape[1] else values.T
        if index > values.shape[1]:
            raise NotComputableError(f"{path.name}: {of} has {values.shape[1]} columns, not {index}")
        values = values[:, index - 1]
    if values.ndim != 1:
        shape = "×".join(map(str, values.shape)) or "a scalar"
        raise NotComputableError(f"{path.name}: {of} is {shape}, no column; choose one as in {of}[1]")
    if not np.issubdtype(values.dtype, np.number) or np.iscomplexobj(values):
        raise NotComputableError(f"{path.name}: {of} holds no real numbers")
    return values.astype(float)
