"""A table in lines of text: aligned columns, cells of several lines, broken where space is short."""

from __future__ import annotations

from itertools import zip_longest

from obscli.core.document import Align, Cell, Column, Table, Text
from obscli.core.visible import visible
from obscli.render.columns import GAP, column_widths
from obscli.render.line import Line, cell_width, line_width
from obscli.render.wrap import wrap


def table_lines(table: Table, width: int) -> list[Line]:
    """Return the table in lines of at most ``width`` cells (as far as that can be done)."""
    header = tuple(((Text(column.title, "faint"),),) for column in table.columns)
    titled = any(column.title for column in table.columns)
    rows = ((header,) if titled else ()) + table.rows
    widths = column_widths(_natural(rows, len(table.columns)), [c.breaks for c in table.columns], width)
    return [line for row in rows for line in _row_lines(row, table.columns, widths)]


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
