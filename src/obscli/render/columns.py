"""How wide each column of a table may be on a surface of given width."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final


#: Blanks between two columns.
GAP: Final = 2

#: No column is squeezed below this.
NARROWEST: Final = 6

#: A column that need not be broken is broken all the same beyond this, when space is short.
WIDEST_FIXED: Final = 28


def column_widths(natural: Sequence[int], breaks: Sequence[bool], width: int) -> list[int]:
    """Return the widths: natural where all fits, else the breaking columns share what the others leave.

    Parameters
    ----------
    natural : the width each column would take unbroken
    breaks : which columns may be broken freely
    width : cells available for all columns and the gaps between them
    """
    available = width - GAP * (len(natural) - 1)
    if sum(natural) <= available:
        return list(natural)
    widths = [
        max(own if free else min(own, WIDEST_FIXED), 1) for own, free in zip(natural, breaks, strict=True)
    ]
    _share(widths, [k for k, free in enumerate(breaks) if free], available)
    _share(widths, list(range(len(widths))), available)
    return widths


def _share(widths: list[int], members: list[int], available: int) -> None:
    """Shrink the members in place to an equal share each, small ones leaving their rest to the large."""
    left = available - sum(own for k, own in enumerate(widths) if k not in members)
    if sum(widths[k] for k in members) <= left:
        return
    for count, k in enumerate(sorted(members, key=lambda k: widths[k])):
        share = max(left // (len(members) - count), NARROWEST)
        widths[k] = min(widths[k], share)
        left -= widths[k]
