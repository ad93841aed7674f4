"""Instants put together: consecutive ones that say the same take one row of a table."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import groupby
from typing import Protocol, TypeVar

from obscli.core.number import plain


class AtInstant(Protocol):
    """Something that belongs to an instant."""

    @property
    def t(self) -> float:
        """The instant."""


P = TypeVar("P", bound=AtInstant)


def runs(points: Iterable[P], key: Callable[[P], object]) -> list[tuple[P, ...]]:
    """Return the consecutive points with the same key, each run once."""
    return [tuple(run) for _, run in groupby(points, key)]


def span(points: tuple[P, ...]) -> str:
    """Return ``10`` or ``10 … 1500``."""
    first, last = points[0].t, points[-1].t
    return plain(first) if len(points) == 1 else f"{plain(first)} … {plain(last)}"
