"""The neutral figure: curves and maps with their meaning, before any library draws them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias


#: How a curve stands out: the matter itself, what it is compared with, a limit, or one of many alike.
Emphasis: TypeAlias = Literal["main", "reference", "limit", "one of many"]


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """Values at instants; ``marked``: as marks instead of a line."""

    label: str
    x: tuple[float, ...]
    y: tuple[float, ...]
    emphasis: Emphasis = "main"
    marked: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Panel:
    """One pair of axes: curves over the same abscissa; ``marks``: values of it worth a line."""

    title: str
    y_label: str
    curves: tuple[Curve, ...]
    logarithmic: bool = False
    marks: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class HeatMap:
    """A table of greys.

    Parameters
    ----------
    rows, columns : their labels
    values : of every row, from 0 (white) to 1 (dark); None where there is no value
    texts : of every row, what is written in its cells where there is room
    legend : what dark means
    """

    title: str
    rows: tuple[str, ...]
    columns: tuple[str, ...]
    values: tuple[tuple[float | None, ...], ...]
    texts: tuple[tuple[str, ...], ...]
    legend: str


@dataclass(frozen=True, slots=True, eq=False)
class Figure:
    """Panels and maps below each other; ``name`` becomes the name of a file, ``x_label`` is the panels'."""

    name: str
    title: str
    x_label: str
    panels: tuple[Panel | HeatMap, ...]
