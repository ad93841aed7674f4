"""A table in lines of text: aligned columns, cells of several lines, broken where space is short."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import zip_longest

from obscli.core.document import Align, Cell, Column, Table, Text
from obscli.core.visible import visible
from obscli.render.columns import GAP, column_widths
from obscli.render.line import Line, cell_width, line_width
from obscli.render.wrap import wrap


def table_lines(table: Table, width: int) -> list[Line]:
    """Return the table in lines of at most ``width`` cells (as far as that can be done).

    One that folds is set in parts below each other where it is wider.
    """
    header = tuple(((Text(column.title, "faint"),),) for column in table.columns)
    titled = any(column.title for column in table.columns)
    rows = ((header,) if titled else ()) + table.rows
    natural = _natural(rows, len(table.columns))
    lines: list[Line] = []
    for part in _parts(natural, width) if table.folds else [tuple(range(len(natural)))]:
        columns = tuple(table.columns[k] for k in part)
        widths = column_widths([natural[k] for k in part], [one.breaks for one in columns], width)
        lines += [()] if lines else []
        lines += [line for row in rows for line in _row_lines(tuple(row[k] for k in part), columns, widths)]
    return lines


def _parts(natural: Sequence[int], width: int) -> list[tuple[int, ...]]:
    """Return the columns in parts that fit, as evenly as they come, the first column in each."""
    first, rest = min(natural[0], width // 2), range(1, len(natural))
    for count in range(1, len(natural)):
        size = -(-len(rest) // count)
        parts = [(0, *rest[k : k + size]) for k in range(0, len(rest), size)]
        if all(first + sum(natural[k] + GAP for k in part[1:]) <= width for part in parts):
            return parts
    return [(0, k) for k in rest]


def _natural(rows: tuple[tuple[Cell, ...], ...], count: int) -> list[int]:
    widths = [0] * count
    for row in rows:
        for k, cell in enumerate(row):
            for content in cell:
                widths[k] = max(widths[k], sum(cell_width(visible(part.text)) for part in content))
    return widths


def _row_lines(row: tuple[Cell, ...], columns: tuple[Column, ...], widths: list[int]) -> list[Line]:
    cells = [
        [line for content in cell for line in wrap(content, width)]
        for cell, width in zip(row, widths, strict=True)
    ]
    return [
        tuple(
            piece
            for k, part in enumerate(parts)
            for piece in _padded(part, widths[k], columns[k].align, last=k == len(widths) - 1)
        )
        for parts in zip_longest(*cells, fillvalue=())
    ]


def _padded(line: Line, width: int, align: Align, *, last: bool) -> Line:
    space = max(width - line_width(line), 0)
    before = {"left": 0, "right": space, "centre": space // 2}[align]
    after = space - before + GAP
    return ((" " * before, "plain"), *line, *(() if last else ((" " * after, "plain"),)))
