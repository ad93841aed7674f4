"""``signals``: columns of files as functions of time.

signals: {file: imu.csv, time: {column: t_ms, factor: 1e-3, zero: first}, interpolation: cubic,
          columns: {f_b: [fx, fy, fz], yaw: {column: hdg_deg, factor: pi/180, unwrap: 360}}}

Names under ``columns`` are functions of time; one listed under ``functions`` too has the relations given
there. Factors are numbers; times are (column − zero) · factor, values column · factor, unwrapped before.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, cast

from obscli.model.constant import constant, unchanging
from obscli.model.declaration import Declared, component_names
from obscli.model.draft import Draft, FunctionDraft
from obscli.model.expression import Expression
from obscli.model.formula import formula
from obscli.model.keys import Fields, choice_of, fields, name_of, text_of
from obscli.model.meter import Meter
from obscli.model.scope import Absent, Scope
from obscli.model.sign import sign
from obscli.model.signal_draft import ColumnDraft, SignalDraft, SignalFileDraft
from obscli.model.signal_file import Interpolation, SignalColumn, SignalFile
from obscli.model.table_header import TableError, names_in
from obscli.model.tensor import named
from obscli.model.tree import Broken, Node, Scalar, Sequence
from obscli.model.tree import Mapping as MappingNode
from obscli.model.trouble import Problems, nearest, shown


SIGNAL_KEYS: Final = ("file", "time", "interpolation", "max_gap", "columns")
TIME_KEYS: Final = ("column", "factor", "zero")
COLUMN_KEYS: Final = ("column", "factor", "unwrap")
INTERPOLATIONS: Final = ("cubic", "linear", "previous")
_SHOWN: Final = 30


def with_signals(
    draft: Draft, base: Draft | None, directory: Path, problems: Problems, path: str = "signals"
) -> Draft:
    """Return a draft with the functions of its ``signals``.

    Parameters
    ----------
    base : the draft that this one, of a stage, replaces parts of; None: this is the base
    directory : of the model file, which paths start from
    path : of the key
    """
    if draft.signals is None:
        return draft
    above = draft if base is None else base
    reading = _Reading(directory, list(above.parameters), problems)
    files = tuple(reading.file(node, path) for node in _files(draft.signals))
    listed = {one.declared.name: one.declared for one in above.functions if not one.implied}
    functions: dict[str, FunctionDraft] = {}
    for one in (one for file in files for one in file.signals):
        if one.name in functions:
            problems.add(one.key.problem(path, f"the signal '{shown(one.name)}' is given twice"))
        elif one.name not in listed:
            cells = component_names(one.name, one.shape)
            functions[one.name] = FunctionDraft(
                Declared(one.name, one.key, one.shape, cells, {}), implied=True
            )
        elif listed[one.name].shape != one.shape:
            message = (
                f"'{one.name}' is {named(listed[one.name].shape)} under `functions`, not {named(one.shape)}"
            )
            problems.add(one.key.problem(path, message))
    if base is not None:
        _check_names(functions, base, path, problems)
    kept = tuple(one for one in draft.functions if not one.implied)
    return replace(draft, functions=(*kept, *functions.values()), sampled=files)


def _files(node: Node) -> tuple[Node, ...]:
    return node.items if isinstance(node, Sequence) else (node,)


def _check_names(functions: Mapping[str, FunctionDraft], base: Draft, path: str, problems: Problems) -> None:
    """Report signals of a stage with names that the file uses for something else."""
    taken = {base.time or "t", *base.parameters, *base.let}
    for group in (base.states, base.inputs, base.disturbances):
        taken |= {name for one in group for name in (one.name, *one.components)}
    for name, one in functions.items():
        if name in taken:
            message = f"the name '{shown(name)}' is taken: it is something else in this file"
            problems.add(one.declared.key.problem(path, message))


@dataclass(frozen=True, slots=True, eq=False)
class _Reading:
    """Reads the files of one ``signals``; ``parameters``: names that have no place in it."""

    directory: Path
    parameters: list[str]
    problems: Problems

    def file(self, node: Node, path: str) -> SignalFileDraft:
        """Return one file with its columns."""
        given = fields(node, path, SIGNAL_KEYS, self.problems)
        name = text_of(given.get("file"), f"{path}.file", self.problems)
        file = self.directory / name if name else None
        time, factor, zero = self._time(given, node, path)
        signals = tuple(self._signals(given, node, path))
        if file is not None:
            columns = [column for one in signals for column in one.columns]
            names = [("time", time), *((one.column.text, one.column) for one in columns)]
            self._check_columns(given["file"][1], file, [node for _, node in names if node], path)
        kind = choice_of(given.get("interpolation"), f"{path}.interpolation", INTERPOLATIONS, self.problems)
        return SignalFileDraft(
            node=node,
            file=file,
            time=time,
            factor=factor,
            zero=zero,
            interpolation=cast("Interpolation", kind or "cubic"),
            max_gap=self._number(given, "max_gap", path),
            signals=signals,
        )

    def _time(
        self, given: Fields, node: Node, path: str
    ) -> tuple[Scalar | None, Expression | None, Expression | str]:
        """Return the column of the time, its factor and its zero."""
        if "time" not in given:
            if isinstance(node, MappingNode):
                hint = "time: t, or time: {column: t_ms, factor: 1e-3, zero: first}"
                self.problems.add(node.problem(path, "`time` is missing: the column with the times", hint))
            return None, None, "value"
        value, below = given["time"][1], f"{path}.time"
        if isinstance(value, Scalar):
            return self._column(value, below), None, "value"
        inner = fields(value, below, TIME_KEYS, self.problems)
        if "column" not in inner:
            self.problems.add(value.problem(below, "`column` is missing: the column with the times"))
        zero: Expression | str = "value"
        if "zero" in inner:
            start = inner["zero"][1]
            text = start.text if isinstance(start, Scalar) else ""
            zero = (
                text
                if text in {"first", "value"}
                else self._number(inner, "zero", below, nonzero=False) or "value"
            )
        column = self._column(inner["column"][1], f"{below}.column") if "column" in inner else None
        return column, self._number(inner, "factor", below), zero

    def _column(self, node: Node, path: str) -> Scalar | None:
        """Return the name of a column."""
        if isinstance(node, Scalar) and not node.is_null:
            return node
        if not isinstance(node, Broken):
            self.problems.add(node.problem(path, "the name of a column is expected here"))
        return None

    def _number(self, given: Fields, key: str, path: str, *, nonzero: bool = True) -> Expression | None:
        """Return a number, None where it is not given or wrong; ``nonzero``: it must not be zero."""
        if key not in given:
            return None
        node, below = given[key][1], f"{path}.{key}"
        if isinstance(node, Scalar) and node.is_null:
            self.problems.add(node.problem(below, "a number is missing here"))
            return None
        hint = "write the number itself; parameters have no place in `signals`"
        absent = {name: Absent(f"'{name}' is a parameter", hint) for name in self.parameters}
        value = constant(
            formula(node, below, self.problems), Scope({}, unchanging, Meter(), absent), self.problems
        )
        if value is None:
            return None
        found = sign(value)
        if nonzero and found == 0:
            self.problems.add(node.problem(below, "this must not be zero"))
            return None
        if key in {"max_gap", "unwrap"} and found == -1:
            self.problems.add(node.problem(below, "a positive number is expected here"))
            return None
        return value

    def _signals(self, given: Fields, node: Node, path: str) -> Iterator[SignalDraft]:
        if "columns" not in given:
            if isinstance(node, MappingNode):
                hint = "columns: {f_b: [fx, fy, fz], yaw: {column: hdg_deg, factor: pi/180}}"
                message = "`columns` is missing: the functions of time, with the columns they are in"
                self.problems.add(node.problem(path, message, hint))
            return
        below = f"{path}.columns"
        for name, (key, value) in fields(given["columns"][1], below, None, self.problems).items():
            if name_of(key, below, self.problems) is not None:
                yield self._signal(name, key, value, f"{below}.{name}")

    def _signal(self, name: str, key: Scalar, node: Node, path: str) -> SignalDraft:
        """Return one signal: a column, a list of them, or of lists, or a mapping around one of these."""
        factor = unwrap = None
        value: Node | None = node
        if isinstance(node, MappingNode):
            given = fields(node, path, COLUMN_KEYS, self.problems)
            factor, unwrap = self._number(given, "factor", path), self._number(given, "unwrap", path)
            value = given["column"][1] if "column" in given else None
            if value is None:
                self.problems.add(node.problem(path, "`column` is missing: the column, or a list of them"))
        rows = value.items if isinstance(value, Sequence) else ()
        shape: tuple[int, ...] = (len(rows),) if isinstance(value, Sequence) else ()
        if rows and all(isinstance(row, Sequence) for row in rows):
            lengths = {len(row.items) for row in rows if isinstance(row, Sequence)}
            shape = (len(rows), max(lengths))
            if len(lengths) > 1:
                self.problems.add(node.problem(path, "the rows of this matrix are of different lengths"))
            rows = tuple(item for row in rows if isinstance(row, Sequence) for item in row.items)
        if isinstance(value, Sequence) and not rows:
            self.problems.add(value.problem(path, "the list of columns is empty"))
        nodes = rows if isinstance(value, Sequence) else (value,) if value is not None else ()
        columns = tuple(
            one for item in nodes if (one := self._component(item, path, factor, unwrap)) is not None
        )
        return SignalDraft(name, key, () if shape == (1,) else shape, columns)

    def _component(
        self, node: Node, path: str, factor: Expression | None, unwrap: Expression | None
    ) -> ColumnDraft | None:
        if isinstance(node, MappingNode):
            given = fields(node, path, COLUMN_KEYS, self.problems)
            factor = self._number(given, "factor", path) or factor
            unwrap = self._number(given, "unwrap", path) or unwrap
            if "column" not in given:
                self.problems.add(node.problem(path, "`column` is missing: the name of a column"))
                return None
            node = given["column"][1]
        column = self._column(node, path)
        return None if column is None else ColumnDraft(column, factor, unwrap)

    def _check_columns(self, node: Node, file: Path, columns: list[Scalar], path: str) -> None:
        """Report columns that the file does not have, or has twice."""
        try:
            names = names_in(file)
        except TableError as error:
            self.problems.add(
                node.problem(f"{path}.file", f"{shown(file.name)}: {error.message}", error.hint)
            )
            return
        if names is None:
            return
        listed = [shown(name) for name in names if name][:_SHOWN]
        hint = f"columns: {', '.join(listed)}{', …' if len(names) > _SHOWN else ''}"
        for column in columns:
            name = variable_of(column.text)[0] if file.suffix.lower() == ".npz" else column.text
            if names.count(name) > 1:
                message = f"{shown(file.name)} has {names.count(name)} columns '{shown(name)}'"
                self.problems.add(column.problem(f"{path}.columns", message, "rename all but one of them"))
            elif name not in names:
                message = f"'{shown(name)}' is no column of {shown(file.name)}{nearest(name, names)}"
                self.problems.add(column.problem(f"{path}.columns", message, hint))


def variable_of(text: str) -> tuple[str, int | None]:
    """Return the variable of an archive, and which of its columns (from 1) where it says: ``f[2]``."""
    name, _, rest = text.partition("[")
    index = rest.removesuffix("]")
    return (name, int(index)) if rest.endswith("]") and index.isdigit() and int(index) else (text, None)


def signal_files(draft: Draft, left: Collection[str]) -> tuple[SignalFile, ...]:
    """Return the files of a stage, every column by the name of the scalar function it is.

    Parameters
    ----------
    left : the functions that have no other value; columns of others are not read
    """
    cells = {one.declared.name: one.declared.cells for one in draft.functions}
    found = []
    for file in draft.sampled or ():
        columns = tuple(
            SignalColumn(cell, column.column.text, column.factor, column.unwrap, column.column.place)
            for one in file.signals
            for cell, column in zip(cells.get(one.name, ()), one.columns, strict=False)
            if cell is not None and cell in left
        )
        if file.file is not None and file.time is not None:
            found.append(
                SignalFile(
                    file=file.file,
                    place=file.node.place,
                    time=file.time.text,
                    columns=columns,
                    factor=file.factor,
                    zero=file.zero,
                    interpolation=file.interpolation,
                    max_gap=file.max_gap,
                )
            )
    return tuple(found)
