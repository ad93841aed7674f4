"""Figures drawn with matplotlib: black on white, told apart by line and mark, not by colour."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from obscli.core.figure import Curve, Emphasis, Figure, Panel
from obscli.core.visible import visible


if TYPE_CHECKING:
    from matplotlib.axes import Axes


#: Line style, width and grey of each emphasis.
STYLES: Final[dict[Emphasis, dict[str, Any]]] = {
    "main": {"linestyle": "-", "linewidth": 1.4, "color": "black"},
    "reference": {"linestyle": "--", "linewidth": 1.2, "color": "0.25"},
    "limit": {"linestyle": ":", "linewidth": 1.4, "color": "black"},
    "one of many": {"linestyle": "-", "linewidth": 0.8, "color": "0.55"},
}
MARKS: Final[dict[str, Any]] = {
    "linestyle": "none",
    "marker": "o",
    "markersize": 3.0,
    "markerfacecolor": "none",
}
FORMATS: Final = ("svg", "png")
WIDTH: Final = 6.4
HEIGHT: Final = 2.6
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
    from matplotlib import rc_context  # noqa: PLC0415 - a second to import, for figures only
    from matplotlib.figure import Figure as Canvas  # noqa: PLC0415

    count = len(figure.panels)
    height = 1.6 * HEIGHT if count == 1 else HEIGHT * count
    canvas = Canvas(figsize=(WIDTH, height), layout="constrained")
    axes = canvas.subplots(count, 1, sharex=True, squeeze=False)[:, 0]
    for panel, one in zip(figure.panels, axes, strict=True):
        _draw(panel, one)
    axes[-1].set_xlabel(_text(figure.x_label))
    canvas.suptitle(_text(figure.title), fontsize="medium")
    files = tuple(directory / f"{file_name(figure.name)}.{form}" for form in FORMATS)
    with rc_context({"svg.hashsalt": figure.name}):  # a date or random names would make every drawing another
        for file in files:
            canvas.savefig(file, dpi=150, metadata={"Date": None} if file.suffix == ".svg" else None)
    return files


def file_name(name: str) -> str:
    """Return a name that every file system takes."""
    return re.sub(r"[^\w.-]+", "_", visible(name)).strip("._") or "figure"


def _draw(panel: Panel, axes: Axes) -> None:
    for curve in panel.curves:
        style = STYLES[curve.emphasis] | (MARKS if curve.marked else {})
        axes.plot(curve.x, curve.y, label=_text(curve.label), **style)
    if panel.logarithmic and any(value > 0 for curve in panel.curves for value in curve.y):
        axes.set_yscale("log")
    else:
        _steady(panel, axes)
    axes.set_ylabel(_text(panel.y_label))
    axes.set_title(_text(panel.title), fontsize="small", loc="left")
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


def _text(text: str) -> str:
    """Return text that matplotlib shows as it is: dollars would start a formula."""
    return visible(text).replace("$", r"\$")
