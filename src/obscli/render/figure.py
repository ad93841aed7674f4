"""Figures drawn with matplotlib: black on white, told apart by line and mark, not by colour."""

from __future__ import annotations

import re
from contextlib import AbstractContextManager
from io import StringIO
from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, cast

from obscli.core.figure import Curve, Emphasis, Figure, HeatMap, Panel
from obscli.core.visible import visible
from obscli.render import heat_map
from obscli.render.figure_text import in_figure


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas
    from matplotlib.gridspec import SubplotSpec


#: Line style, width and grey of each emphasis.
STYLES: Final[dict[Emphasis, dict[str, Any]]] = {
    "main": {"linestyle": "-", "linewidth": 1.4, "color": "black"},
    "reference": {"linestyle": "--", "linewidth": 1.2, "color": "0.25"},
    "limit": {"linestyle": ":", "linewidth": 1.4, "color": "black"},
    "one of many": {"linestyle": "-", "linewidth": 0.8, "color": "0.55"},
}
#: How several main curves of a panel are told apart: the line of each in turn.
LINES: Final[tuple[dict[str, Any], ...]] = (
    {},
    {"linestyle": (0, (6, 2))},
    {"linestyle": (0, (6, 2, 1, 2))},
    {"linestyle": (0, (2, 1.5))},
    {"color": "0.55", "linewidth": 2.0},
    {"color": "0.55", "linewidth": 2.0, "linestyle": (0, (6, 2))},
)
MARKS: Final[dict[str, Any]] = {
    "linestyle": "none",
    "marker": "o",
    "markersize": 3.0,
    "markerfacecolor": "none",
}
FORMATS: Final = ("svg", "png")
WIDTH: Final = 6.4
HEIGHT: Final = 2.6

#: How much of a panel's height its title and labels take, where it stands beside a heat map.
LABELS: Final = 0.7

#: What matplotlib would write about itself into an SVG.
METADATA: Final = ("Creator", "Date", "Format", "Type")

MOST_LABELS: Final = 6

#: Relative variation below which a curve is drawn as constant.
FLAT: Final = 1e-2


def save(figure: Figure, directory: Path) -> tuple[Path, ...]:
    """Draw a figure into a directory, one file a format; return the files.

    Raises
    ------
    OSError
        where a file cannot be written
    """
    canvas = _canvas(figure)
    files = tuple(directory / f"{file_name(figure.name)}.{form}" for form in FORMATS)
    with _named(figure):
        for file in files:
            canvas.savefig(file, dpi=150, metadata={"Date": None} if file.suffix == ".svg" else None)
    return files


def svg_element(figure: Figure, prefix: str) -> str:
    """Return a figure as an SVG element for a page, every id in it after a ``prefix`` of its own.

    No prolog, metadata, comments or namespaces: a page needs none, and so nothing in it names an address.
    """
    file = StringIO()
    with _named(figure):
        _canvas(figure).savefig(file, format="svg", metadata=dict.fromkeys(METADATA))
    text = file.getvalue()
    text = re.sub(r"<!--.*?-->\n?", "", text[text.index("<svg") :], flags=re.DOTALL)
    text = re.sub(r' xmlns(:\w+)?="[^"]*"', "", text)
    return re.sub(r'( id="|href="#|url\(#)', rf"\g<1>{prefix}", text).rstrip()


def file_name(name: str) -> str:
    """Return a name that every file system takes."""
    return re.sub(r"[^\w.-]+", "_", visible(name)).strip("._") or "figure"


def _named(figure: Figure) -> AbstractContextManager[None]:
    """Make the names inside a drawing from that of the figure: random ones would make each another."""
    from matplotlib import rc_context  # noqa: PLC0415 - a second to import, for figures only

    return cast("AbstractContextManager[None]", rc_context({"svg.hashsalt": figure.name}))


def _canvas(figure: Figure) -> Canvas:
    """Return the figure drawn: panels over one abscissa, every heat map by itself."""
    maps = [one for one in figure.panels if isinstance(one, HeatMap)]
    width = max([WIDTH, *(heat_map.natural_width(one) for one in maps)])
    canvas, places = _laid_out(figure.panels, width)
    shared: list[Axes] = []
    mapped = []
    for panel, place in zip(figure.panels, places, strict=True):
        if isinstance(panel, HeatMap):
            mapped.append(canvas.add_subplot(place))
            heat_map.draw(panel, mapped[-1], width)
        else:
            shared.append(canvas.add_subplot(place, sharex=shared[0] if shared else None))
            _draw(panel, shared[-1])
    _label_abscissa(shared, in_figure(figure.x_label))
    canvas.suptitle(in_figure(figure.title), fontsize="medium")
    if maps:
        _write(maps, mapped, canvas)
    return canvas


def _write(maps: list[HeatMap], mapped: list[Axes], canvas: Canvas) -> None:
    """Write into the cells: whether a text fits is known when all has its place."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415

    agg: Any = FigureCanvasAgg(canvas)
    renderer = agg.get_renderer()
    canvas.draw_without_rendering()
    for one, axes in zip(maps, mapped, strict=True):
        heat_map.write(one, axes, renderer)


def _laid_out(panels: tuple[Panel | HeatMap, ...], width: float) -> tuple[Canvas, list[SubplotSpec]]:
    """Return an empty canvas and the place of every panel on it."""
    from matplotlib.figure import Figure as Canvas  # noqa: PLC0415

    sizes = [
        heat_map.heights(one, width) if isinstance(one, HeatMap) else (HEIGHT - LABELS, LABELS)
        for one in panels
    ]
    alone = len(panels) == 1 and isinstance(panels[0], Panel)
    height = 1.6 * HEIGHT if alone else sum(inner + outer for inner, outer in sizes)
    canvas = Canvas(figsize=(width, height), layout="constrained")
    grid = canvas.add_gridspec(len(sizes), 1, height_ratios=[inner for inner, _ in sizes])
    return canvas, [grid[k] for k in range(len(sizes))]


def _label_abscissa(axes: list[Axes], label: str) -> None:
    """Label the abscissa that axes below each other share, under the last of them."""
    for one in axes[:-1]:
        one.tick_params(axis="x", which="both", labelbottom=False)
        one.xaxis.offsetText.set_visible(False)
    for one in axes[-1:]:
        one.set_xlabel(label)


def _draw(panel: Panel, axes: Axes) -> None:
    for mark in panel.marks:
        axes.axvline(mark, color="0.75", linewidth=0.8, linestyle=(0, (4, 4)))
    line = cycle(LINES)
    for curve in panel.curves:
        style = STYLES[curve.emphasis] | (MARKS if curve.marked else {})
        if curve.emphasis == "main" and not curve.marked:
            style |= next(line)
        axes.plot(curve.x, curve.y, label=in_figure(curve.label), **style)
    if panel.logarithmic and any(value > 0 for curve in panel.curves for value in curve.y):
        axes.set_yscale("log")
    else:
        _steady(panel, axes)
    axes.set_ylabel(in_figure(panel.y_label))
    axes.set_title(in_figure(panel.title), fontsize="small", loc="left")
    axes.grid(visible=True, color="0.9", linewidth=0.6)
    _label(panel.curves, axes)


def _steady(panel: Panel, axes: Axes) -> None:
    """Show what hardly varies as constant, not its last digits."""
    values = [value for curve in panel.curves for value in curve.y]
    low, high = min(values, default=0.0), max(values, default=0.0)
    size = max(abs(low), abs(high))
    if high - low < FLAT * size:
        axes.set_ylim(low - size / 2, high + size / 2)
    axes.ticklabel_format(useOffset=False, axis="y")


def _label(curves: tuple[Curve, ...], axes: Axes) -> None:
    named = [curve for curve in curves if curve.label]
    if named:
        axes.legend(fontsize="x-small", loc="best", framealpha=0.9, ncols=1 + (len(named) > MOST_LABELS))
