"""Heat maps drawn with matplotlib: a table of greys that grows with its cells."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Final

from obscli.core.figure import HeatMap
from obscli.core.visible import visible
from obscli.render.figure_text import in_figure
from obscli.render.line import cell_width


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.backend_bases import RendererBase


#: Height of a row and least width of a column, in inches.
ROW: Final = 0.19
COLUMN: Final = 0.24

#: Letters of labels and cells, in points, and the width of a usual one in inches.
SIZE: Final = 7.0
LETTER: Final = 0.62 * SIZE / 72

#: Texts of cells make columns wider up to this many letters; longer ones are written where there is room.
LETTERS: Final = 9

#: Letters of the title and the key.
LARGER: Final = 8.5

#: What stands around the cells besides labels, title and key, in inches.
AROUND: Final = 0.3
PAD: Final = 0.15

#: Maps of more rows have their columns named below as well.
LONG: Final = 40

#: Cells take no more than this many inches together: beyond it, they shrink.
LARGEST: Final = 100.0

#: Longer labels of rows and columns are cut.
LONGEST_LABEL: Final = 60

LIGHTEST: Final = "1.0"
DARKEST: Final = "0.1"
LINES: Final = "0.8"

CENTRED: Final[dict[str, Any]] = {
    "horizontalalignment": "center",
    "verticalalignment": "center_baseline",
}

#: How much of the width of a cell its text may take.
FILLED: Final = 0.94

#: From this value on, cells are dark: writing is white.
DARK: Final = 0.6


def natural_width(heat: HeatMap) -> float:
    """Return how wide a map would be, labels included, in inches."""
    longest = min(_longest(text for row in heat.texts for text in row), LETTERS)
    column = max(COLUMN, longest * LETTER + PAD / 2)
    return _beside(heat) + min(len(heat.columns) * column, LARGEST)


def heights(heat: HeatMap, width: float) -> tuple[float, float]:
    """Return how high the cells of a map are together, and all that stands above and below them."""
    labels = _longest(map(_label, heat.columns)) * LETTER if _upright(heat, width) else ROW
    sides = 1 + (len(heat.rows) > LONG)
    words = sum(_wrapped(text, heat, width).count("\n") + 1 for text in (heat.title, _key(heat)))
    return min(max(len(heat.rows), 1) * ROW, LARGEST), labels * sides + words * ROW + AROUND


def draw(heat: HeatMap, axes: Axes, width: float) -> None:
    """Draw a map, all but the texts of its cells, on a canvas of given width in inches."""
    if _is_incomplete(heat):
        axes.patch.set(hatch="//////", edgecolor=LINES)  # seen through the cells that have no value
    _cells(heat, axes)
    long = len(heat.rows) > LONG
    axes.tick_params(length=0, labelsize=SIZE, top=True, labeltop=True, labelbottom=long)
    axes.set_xticks(
        [k + 0.5 for k in range(len(heat.columns))],
        labels=[in_figure(_label(name)) for name in heat.columns],
        rotation="vertical" if _upright(heat, width) else "horizontal",
    )
    axes.set_yticks(
        [k + 0.5 for k in range(len(heat.rows))], labels=[in_figure(_label(name)) for name in heat.rows]
    )
    axes.set_title(_wrapped(heat.title, heat, width), fontsize=LARGER, loc="left")
    axes.set_xlabel(_wrapped(_key(heat), heat, width), fontsize=LARGER, loc="left")


def write(heat: HeatMap, axes: Axes, renderer: RendererBase) -> None:
    """Write the texts into the cells of a map that is laid out, where they fit."""
    box = axes.get_window_extent()
    room = box.width / max(len(heat.columns), 1), box.height / max(len(heat.rows), 1)
    for i, (values, texts) in enumerate(zip(heat.values, heat.texts, strict=True)):
        for j, (value, text) in enumerate(zip(values, texts, strict=True)):
            if text:
                written = axes.text(j + 0.5, i + 0.5, in_figure(text), fontsize=SIZE, **CENTRED)
                written.set_color("white" if value is not None and value >= DARK else "black")
                written.set_in_layout(False)
                extent = written.get_window_extent(renderer)
                if extent.width > FILLED * room[0] or extent.height > room[1]:
                    written.remove()


def _cells(heat: HeatMap, axes: Axes) -> None:
    import numpy as np  # noqa: PLC0415 - for figures only
    from matplotlib.colors import LinearSegmentedColormap  # noqa: PLC0415

    axes.set_xlim(0, max(len(heat.columns), 1))
    axes.set_ylim(max(len(heat.rows), 1), 0)
    if not heat.rows or not heat.columns:
        return
    values = np.array([[np.nan if v is None else v for v in row] for row in heat.values])
    greys = LinearSegmentedColormap.from_list("greys", [LIGHTEST, DARKEST])
    axes.pcolormesh(np.ma.masked_invalid(values), cmap=greys, vmin=0, vmax=1, edgecolors=LINES, linewidth=0.4)


def _key(heat: HeatMap) -> str:
    return f"■ {heat.legend}" + "    ▨ no value" * _is_incomplete(heat)


def _is_incomplete(heat: HeatMap) -> bool:
    return any(value is None for row in heat.values for value in row)


def _wrapped(text: str, heat: HeatMap, width: float) -> str:
    """Return text in lines of the width of the cells."""
    room = max(int((width - _beside(heat)) / (LETTER * LARGER / SIZE)), 1)
    return "\n".join(in_figure(line) for line in textwrap.wrap(visible(text), room))


def _upright(heat: HeatMap, width: float) -> bool:
    """Tell whether the names of the columns are too long to stand beside each other."""
    room = (width - _beside(heat)) / max(len(heat.columns), 1)
    return _longest(map(_label, heat.columns)) * LETTER > room - LETTER


def _label(name: str) -> str:
    return name if len(name) <= LONGEST_LABEL else name[: LONGEST_LABEL - 1] + "…"


def _beside(heat: HeatMap) -> float:
    return _longest(map(_label, heat.rows)) * LETTER + 2 * PAD


def _longest(texts: Iterable[str]) -> int:
    return max((cell_width(visible(text)) for text in texts), default=0)
